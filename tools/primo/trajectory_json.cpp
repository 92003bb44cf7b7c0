#include "primo/trajectory_json.h"

#include <cmath>
#include <cstdint>

namespace primo::tool {

using Json = nlohmann::ordered_json;

namespace {

Json to_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Json trajectory_json(const motion::Plan& plan) {
  Json K = Json::array();
  for (const auto& gain : plan.gains.K) K.push_back(to_json(gain));
  Json k = Json::array();
  for (const auto& control : plan.gains.k) k.push_back(std::vector<double>(control.begin(), control.end()));
  return {{"joints", plan.trajectory.joints},
          {"dt", plan.trajectory.dt},
          {"iterations", plan.iterations + plan.rejected},
          {"q", to_json(plan.trajectory.q)},
          {"gains", {{"K", std::move(K)}, {"k", std::move(k)}}}};
}

Json to_json(const motion::Plan& plan, const motion::Measures& measures, double milliseconds) {
  Json tasks = Json::object();
  for (const auto& task : plan.cost_tasks) tasks[task.task] = task.cost;
  return {{"status", config::enum_name(plan.status)},
          {"reason", plan.reason},
          {"start", plan.start},
          {"iterations", plan.iterations},
          {"rejected", plan.rejected},
          {"evaluations", plan.evaluations},
          {"cost",
           {{"initial", plan.cost_initial},
            {"final", plan.cost_final},
            {"control", plan.cost_control},
            {"tasks", std::move(tasks)}}},
          {"gradient_norm", plan.gradient_norm},
          {"time_ms", milliseconds},
          {"min_distance_m", measures.min_distance},
          {"min_limit_margin_rad", measures.min_limit_margin},
          {"path_length_rad", measures.path_length}};
}

namespace {

Json survivals_json(const std::vector<physics::Survival>& rows) {
  Json list = Json::array();
  for (const auto& row : rows) {
    list.push_back({{"amplitude", row.amplitude},
                    {"held", row.held},
                    {"seeds", row.seeds},
                    {"survival", row.survival},
                    {"displacement_m", row.displacement}});
  }
  return list;
}

Json contacts_json(const std::vector<physics::Contact>& contacts) {
  Json list = Json::array();
  for (const auto& contact : contacts) {
    list.push_back({{"bodies", {contact.first, contact.second}},
                    {"begin_s", contact.begin},
                    {"end_s", contact.end},
                    {"peak_force_N", contact.peak_force}});
  }
  return list;
}

}  // namespace

Json to_json(const physics::Verdict& verdict, double milliseconds) {
  const auto literals = [](const symbols::State& state) {
    Json list = Json::array();
    for (const auto& literal : state) list.push_back(literal.text());
    return list;
  };
  Json criteria = Json::array();
  for (const auto& criterion : verdict.criteria) {
    criteria.push_back({{"name", criterion.name},
                        {"value", criterion.value},
                        {"margin", criterion.margin},
                        {"indicator", criterion.met ? 1 : 0}});
  }
  return {{"success", verdict.success},
          {"final_pose_success", verdict.final_pose_success},
          {"path_clean", verdict.path_clean},
          {"outcome", config::enum_name(verdict.outcome)},
          {"reason", verdict.reason},
          {"score", verdict.score},
          {"displacement_m", verdict.displacement},
          {"survival", verdict.survival},
          {"position_error_m", verdict.position_error},
          {"criteria", std::move(criteria)},
          {"survivals", survivals_json(verdict.survivals)},
          {"contacts", contacts_json(verdict.contacts)},
          {"unlisted_contacts", verdict.unlisted_contacts},
          {"objects", verdict.objects},
          {"symbols_before", literals(verdict.before)},
          {"symbols_after", literals(verdict.after)},
          {"time_ms", milliseconds},
          {"steps", verdict.steps}};
}

namespace {

constexpr std::size_t kMostJoints = 100, kMostRows = 20001;

Error wrong(const std::string& what) { return {Code::data, what}; }

Result<Eigen::MatrixXd> matrix_from(const Json& rows, std::size_t columns, const std::string& key) {
  if (!rows.is_array() || rows.empty()) return wrong("'" + key + "' must be a list of rows");
  if (rows.size() > kMostRows)
    return wrong("'" + key + "' has " + std::to_string(rows.size()) + " rows, more than " + std::to_string(kMostRows));
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string place = "'" + key + "[" + std::to_string(i) + "]'";
    if (!rows[i].is_array() || rows[i].size() != columns)
      return wrong(place + " must have " + std::to_string(columns) + " numbers");
    for (std::size_t j = 0; j < columns; ++j) {
      if (!rows[i][j].is_number()) return wrong(place + " must hold numbers");
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j].get<double>();
    }
  }
  return matrix;
}

/// The feedback, where the file has it: a list of T matrices n × 2n.
Status read_gains(const Json& json, motion::Plan& plan) {
  const auto gains = json.find("gains");
  if (gains == json.end()) return success();
  const auto K = gains->is_object() ? gains->find("K") : gains->end();
  if (!gains->is_object() || K == gains->end() || !K->is_array())
    return wrong("'gains' must hold 'K', a list of matrices");
  if (!K->empty() && static_cast<Eigen::Index>(K->size()) != plan.trajectory.q.rows() - 1)
    return wrong("'gains.K' must have one matrix a step, " + std::to_string(plan.trajectory.q.rows() - 1));
  const auto columns = static_cast<std::size_t>(2 * plan.trajectory.q.cols());
  for (std::size_t t = 0; t < K->size(); ++t) {
    if ((*K)[t].size() != static_cast<std::size_t>(plan.trajectory.q.cols()))
      return wrong("'gains.K[" + std::to_string(t) + "]' must have a row for each joint");
    PRIMO_ASSIGN(auto gain, matrix_from((*K)[t], columns, "gains.K[" + std::to_string(t) + "]"));
    plan.gains.K.push_back(std::move(gain));
  }
  return success();
}

}  // namespace

Result<motion::Plan> plan_from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return wrong("not a JSON object");
  motion::Plan plan;
  const auto joints = json.find("joints");
  if (joints == json.end() || !joints->is_array()) return wrong("missing 'joints', a list of names");
  if (joints->empty() || joints->size() > kMostJoints)
    return wrong("'joints' must have 1 … " + std::to_string(kMostJoints) + " names");
  for (const auto& joint : *joints) {
    if (!joint.is_string()) return wrong("'joints' must be names");
    plan.trajectory.joints.push_back(joint.get<std::string>());
  }
  const auto dt = json.find("dt");
  if (dt == json.end() || !dt->is_number()) return wrong("missing 'dt', seconds between rows");
  plan.trajectory.dt = dt->get<double>();
  const auto rows = json.find("q");
  if (rows == json.end()) return wrong("missing 'q', a row of joint angles for each step 0 … T");
  PRIMO_ASSIGN(plan.trajectory.q, matrix_from(*rows, plan.trajectory.joints.size(), "q"));
  PRIMO_TRY(read_gains(json, plan));
  plan.status = motion::PlanStatus::converged_step;
  if (const auto iterations = json.find("iterations"); iterations != json.end()) {
    constexpr std::int64_t kMost = 1'000'000;
    const std::int64_t count = iterations->is_number_integer() ? iterations->get<std::int64_t>() : -1;
    if (count < 0 || count > kMost) return wrong("'iterations' must be a whole number, 0 … 1000000");
    plan.iterations = static_cast<int>(count);
  }
  return plan;
}

}  // namespace primo::tool

#include "primo/trajectory_json.h"

#include <cmath>

namespace primo::tool {

using Json = nlohmann::ordered_json;

Json to_json(const motion::Plan& plan) {
  Json tasks = Json::object();
  for (const auto& task : plan.cost_tasks) tasks[task.task] = task.cost;
  Json rows = Json::array();
  for (Eigen::Index t = 0; t < plan.trajectory.q.rows(); ++t) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < plan.trajectory.q.cols(); ++j) row.push_back(plan.trajectory.q(t, j));
    rows.push_back(std::move(row));
  }
  return {{"status", config::enum_name(plan.status)},
          {"reason", plan.reason},
          {"start", plan.start},
          {"iterations", plan.iterations},
          {"rejected", plan.rejected},
          {"cost", {{"initial", plan.cost_initial}, {"final", plan.cost_final}, {"control", plan.cost_control}}},
          {"tasks", std::move(tasks)},
          {"trajectory", {{"joints", plan.trajectory.joints}, {"dt", plan.trajectory.dt}, {"q", std::move(rows)}}}};
}

Json to_json(const physics::Verdict& verdict) {
  const auto literals = [](const symbols::State& state) {
    Json list = Json::array();
    for (const auto& literal : state) list.push_back(literal.text());
    return list;
  };
  Json criteria = Json::array();
  for (const auto& criterion : verdict.criteria) {
    criteria.push_back(
        {{"name", criterion.name}, {"value", criterion.value}, {"margin", criterion.margin}, {"met", criterion.met}});
  }
  return {{"success", verdict.success},
          {"final_pose_success", verdict.final_pose_success},
          {"path_clean", verdict.path_clean},
          {"outcome", config::enum_name(verdict.outcome)},
          {"reason", verdict.reason},
          {"score", verdict.score},
          {"displacement", verdict.displacement},
          {"survival", verdict.survival},
          {"position_error", verdict.position_error},
          {"criteria", std::move(criteria)},
          {"objects", verdict.objects},
          {"before", literals(verdict.before)},
          {"after", literals(verdict.after)}};
}

namespace {

Error wrong(const std::string& what) { return {Code::data, what}; }

Status read_rows(const Json& rows, std::size_t joints, Eigen::MatrixXd& q) {
  if (!rows.is_array() || rows.empty()) return wrong("'trajectory.q' must be a list of rows");
  q.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(joints));
  for (std::size_t t = 0; t < rows.size(); ++t) {
    const std::string place = "'trajectory.q[" + std::to_string(t) + "]'";
    if (!rows[t].is_array() || rows[t].size() != joints) {
      return wrong(place + " must have one number for each of the " + std::to_string(joints) + " joints");
    }
    for (std::size_t j = 0; j < joints; ++j) {
      if (!rows[t][j].is_number()) return wrong(place + " must hold numbers");
      q(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(j)) = rows[t][j].get<double>();
    }
  }
  return success();
}

}  // namespace

Result<motion::Plan> plan_from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return wrong("not a JSON object");
  const auto trajectory = json.find("trajectory");
  if (trajectory == json.end() || !trajectory->is_object()) return wrong("missing 'trajectory'");
  motion::Plan plan;
  const auto joints = trajectory->find("joints");
  if (joints == trajectory->end() || !joints->is_array()) return wrong("missing 'trajectory.joints'");
  for (const auto& joint : *joints) {
    if (!joint.is_string()) return wrong("'trajectory.joints' must be names");
    plan.trajectory.joints.push_back(joint.get<std::string>());
  }
  const auto dt = trajectory->find("dt");
  if (dt == trajectory->end() || !dt->is_number()) return wrong("missing 'trajectory.dt', seconds between rows");
  plan.trajectory.dt = dt->get<double>();
  const auto rows = trajectory->find("q");
  if (rows == trajectory->end()) return wrong("missing 'trajectory.q'");
  PRIMO_TRY(read_rows(*rows, plan.trajectory.joints.size(), plan.trajectory.q));
  plan.status = motion::PlanStatus::converged_step;
  for (const auto& [key, value] : {std::pair{"iterations", &plan.iterations}, {"rejected", &plan.rejected}}) {
    const auto at = json.find(key);
    if (at != json.end() && at->is_number_integer()) *value = at->get<int>();
  }
  return plan;
}

}  // namespace primo::tool

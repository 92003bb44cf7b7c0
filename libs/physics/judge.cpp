#include "physics/judge.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>

#include "physics/aftermath.h"
#include "physics/criteria.h"
#include "physics/execution.h"
#include "physics/place_trial.h"
#include "physics/set_down.h"
#include "physics/survival.h"
#include "robot/distance.h"
#include "scene/held.h"
#include "symbols/predicates.h"

namespace primo::physics {
namespace {

constexpr double kStartTolerance = 1e-3;  // rad, between the plan's first row and the scenario's start
constexpr double kAbsurdAngle = 1e3;      // rad
constexpr double kLongestMotion = 120;    // s
constexpr double kFingerBackOff = 0.4;    // rad
constexpr Eigen::Index kMostSteps = 20000;
constexpr std::size_t kMostObjects = 100;
constexpr std::size_t kMostAmplitudes = 20;

Error malformed(const std::string& message) { return {Code::data, "judge request: " + message}; }

Status check_settings(const JudgeSettings& settings) {
  // The bounds are those of the settings' own table of fields.
  struct Check {
    std::string broken;
    void operator()(const char*, const PlaceCriterion&, const config::Field&) {}
    void operator()(const char* name, const int& value, const config::Field& field) {
      (*this)(name, static_cast<double>(value), field);
    }
    void operator()(const char* name, const std::vector<double>& values, const config::Field& field) {
      if (values.size() > kMostAmplitudes)
        broken = std::string("settings.") + name + " has more than " + std::to_string(kMostAmplitudes) + " numbers";
      for (const double value : values) (*this)(name, value, field);
    }
    void operator()(const char* name, const double& value, const config::Field& field) {
      if (std::isfinite(value) && value >= field.min && value <= field.max) return;
      broken = std::string("settings.") + name + " is " + std::to_string(value) + ", outside " +
               std::to_string(field.min) + " … " + std::to_string(field.max);
    }
  } check;
  JudgeSettings copy = settings;
  copy.visit(check);
  return check.broken.empty() ? success() : malformed(check.broken);
}

Status check_request(const robot::Robot& robot, const JudgeRequest& request) {
  const auto n = static_cast<Eigen::Index>(robot.joints());
  if (request.q.cols() != n) {
    return malformed("q has " + std::to_string(request.q.cols()) + " columns; robot " + robot.name() + " has " +
                     std::to_string(n) + " joints");
  }
  if (request.q.rows() < 2 || request.q.rows() > kMostSteps) {
    return malformed("q has " + std::to_string(request.q.rows()) + " rows; 2 … " + std::to_string(kMostSteps) +
                     " are right");
  }
  if (!request.q.allFinite()) return malformed("q holds a number that is not finite");
  const double duration = request.dt * static_cast<double>(request.q.rows() - 1);
  if (!(request.dt > 0) || !(duration <= kLongestMotion)) {
    return malformed("dt is " + std::to_string(request.dt) + " s; it must be > 0 and the motion at most 120 s long");
  }
  if (request.planner_iterations < 0) return malformed("planner_iterations is negative");
  if (!request.K.empty() && static_cast<Eigen::Index>(request.K.size()) != request.q.rows() - 1) {
    return malformed("K has " + std::to_string(request.K.size()) + " gains; none or one for each of the " +
                     std::to_string(request.q.rows() - 1) + " steps are right");
  }
  for (const auto& K : request.K) {
    if (K.rows() != n || K.cols() != 2 * n || !K.allFinite())
      return malformed("a gain of K is not a finite n × 2n matrix");
  }
  PRIMO_TRY(check_settings(request.settings));
  const auto& scenario = request.scenario;
  if (scenario.objects.size() > kMostObjects) return malformed("more than 100 objects");
  // The scenario came with the request: what is wrong with it is the request's, not a configuration file's.
  if (auto status = scenario.validate(); !status.ok()) return malformed(status.error().message);
  const bool place = scenario.action.size() == 3 && scenario.action[0] == "place";
  if (!place && (scenario.action.size() != 2 || scenario.action[0] != "grasp")) {
    std::string text;
    for (const auto& word : scenario.action) text += (text.empty() ? "" : ", ") + word;
    return malformed("action [" + text +
                     "] is not one the judge knows; it knows [grasp, OBJECT] and [place, OBJECT, SUPPORT]");
  }
  if (!scenario.object(scenario.action[1])) {
    return malformed("action " + scenario.action[0] + " names \"" + scenario.action[1] +
                     "\", which is no object of scenario " + scenario.name);
  }
  if (!scenario.robot_start.empty() && static_cast<Eigen::Index>(scenario.robot_start.size()) != n) {
    return malformed("robot_start has " + std::to_string(scenario.robot_start.size()) + " joints; robot " +
                     robot.name() + " has " + std::to_string(n));
  }
  if (auto status = scene::check_held(scenario, robot); !status.ok()) return malformed(status.error().message);
  return success();
}

/// The request as it is carried out: fingers that hold something stay as they are at the start, whatever the plan says.
JudgeRequest with_fingers_held(const robot::Robot& robot, JudgeRequest request) {
  const auto& start = request.scenario.robot_start;
  for (int j = robot.arm_joints(); j < robot.joints(); ++j)
    request.q.col(j).setConstant(start[static_cast<std::size_t>(j)]);
  return request;
}

/// From the held object at the plan's end to its place on the support, m.
double place_error(const robot::Robot& robot, const JudgeRequest& request) {
  const Eigen::VectorXd q_end = request.q.row(request.q.rows() - 1).transpose();
  const Pose X_WX = robot.pose(robot.forward(q_end), robot.grasp_frame()) * request.scenario.held->X_GO();
  const Stacking at = stacking(request.scenario, X_WX, support_pose(request.scenario));
  return std::hypot(at.offset, at.height);
}

/// Upper bound of the distance from P's origin to any point of the hand, whatever the fingers do, m.
double hand_reach(const robot::Robot& robot) {
  const int palm = robot.tool_body();
  const robot::Kinematics home = robot.forward(robot.home());
  const auto& chain = robot.chain();
  double reach = 0;
  for (const auto& link : robot.link_shapes()) {
    Eigen::Vector3d from = robot.pose(home, link).translation();
    double length = robot::bounding_radius(link.shape);
    int body = link.body;
    for (; body > 0 && body != palm; body = robot.bodies()[static_cast<std::size_t>(body)].parent) {
      for (auto j = chain.size(); j-- > 0;) {
        if (chain[j].body != body) continue;
        length += (from - home.anchor_W[j]).norm();
        from = home.anchor_W[j];
        if (chain[j].slide)
          length += std::abs(chain[j].ratio) * (robot.upper()[chain[j].index] - robot.lower()[chain[j].index]);
      }
    }
    if (body == palm)
      reach = std::max(reach, length + (from - home.X_WB[static_cast<std::size_t>(palm)].translation()).norm());
  }
  return reach;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// What is wrong with a path, in words; empty when it is clean.
std::string complaint(const std::vector<Criterion>& found) {
  std::string text;
  const auto table = criteria();
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (!table[i].strict || found[i].met) continue;
    text += (text.empty() ? "" : ", ") + found[i].name + " " + number(found[i].value) + " " +
            std::string(table[i].unit) + " against " + number(found[i].margin);
  }
  return text;
}

/// The first joint that leaves its limits by more than the margin allows, in words.
std::string first_beyond_limits(const robot::Robot& robot, const JudgeRequest& request) {
  for (Eigen::Index t = 0; t < request.q.rows(); ++t) {
    for (int i = 0; i < robot.joints(); ++i) {
      const double q = request.q(t, i), lower = robot.lower()[i], upper = robot.upper()[i];
      if (std::min(q - lower, upper - q) >= request.settings.limit_margin - 1e-6) continue;
      return "joint " + robot.joint_names()[static_cast<std::size_t>(i)] + " is at " + number(q) + " rad in step " +
             std::to_string(t) + ", its limits are " + number(lower) + " … " + number(upper);
    }
  }
  return {};
}

}  // namespace

struct Judge::Impl {
  using Key = std::tuple<int, double, double, double, double, double>;  // shape type, its sizes, mass, time step

  explicit Impl(robot::Robot r) : robot(std::move(r)), reach(hand_reach(robot)), places(robot) {}

  Result<std::unique_ptr<HandWorkspace>> take(const Key& key, const Shape& shape, double mass, double timestep) {
    {
      const std::lock_guard lock(mutex);
      if (auto found = pool.find(key); found != pool.end() && !found->second.empty()) {
        auto workspace = std::move(found->second.back());
        found->second.pop_back();
        --pooled;
        return workspace;
      }
      if (!whole) {
        auto model = robot_model(robot);
        if (!model.ok()) return model.error();
        whole = std::move(model).value();
      }
    }
    PRIMO_ASSIGN(HandWorkspace made, HandWorkspace::create(robot, whole->get(), shape, mass, timestep));
    return std::make_unique<HandWorkspace>(std::move(made));
  }

  void give_back(const Key& key, std::unique_ptr<HandWorkspace> workspace) {
    constexpr std::size_t kMostPooled = 64;
    const std::lock_guard lock(mutex);
    if (pooled >= kMostPooled) {
      pool.clear();
      pooled = 0;
    }
    pool[key].push_back(std::move(workspace));
    ++pooled;
  }

  Result<TrialResult> final_pose(const JudgeRequest& request, const scene::Object& target, Verdict& verdict);

  const robot::Robot robot;
  const double reach;
  PlaceTrials places;
  std::mutex mutex;
  std::optional<Model> whole;
  std::map<Key, std::vector<std::unique_ptr<HandWorkspace>>> pool;
  std::size_t pooled = 0;
};

Result<TrialResult> Judge::Impl::final_pose(const JudgeRequest& request, const scene::Object& target,
                                            Verdict& verdict) {
  const Eigen::VectorXd q = request.q.row(request.q.rows() - 1).transpose();
  const Pose X_WO = target.X_WO();
  const Shape shape = target.shape();
  TrialResult result;
  ClearanceQuery hand(robot, target_pairs(request.scenario, target.name));
  const double penetration = -hand.at(q);
  if (penetration > request.settings.max_penetration) {
    result.outcome = Outcome::initial_penetration;
    result.reason = "at the final pose the hand is " + number(penetration * 1e3) + " mm inside the object";
    result.score = penetration_score(verdict.position_error, penetration, request.settings.max_penetration);
    return result;
  }
  const Pose X_WP = palm_pose(robot, q);
  // Where no finger can get whatever it does, the simulation could only find no contact.
  if ((X_WO.translation() - X_WP.translation()).norm() > reach + robot::bounding_radius(shape)) {
    result.outcome = Outcome::no_contact;
    result.reason = "at the final pose the object is out of the fingers' reach";
    result.score = miss_score(verdict.position_error);
    return result;
  }
  const Key key{static_cast<int>(shape.type), shape.size.x(), shape.size.y(), shape.size.z(), target.mass,
                request.settings.timestep};
  PRIMO_ASSIGN(auto workspace, take(key, shape, target.mass, request.settings.timestep));
  const Eigen::VectorXd opened = back_off(robot, q, shape, X_WO, kFingerBackOff);
  result = run_trial(robot, *workspace, opened, X_WP, X_WO, verdict.position_error, request.settings, request.seed);
  if (result.outcome == Outcome::held) {
    verdict.survivals = survival_table(robot, *workspace, opened, X_WP, X_WO, request.settings, request.seed);
  }
  give_back(key, std::move(workspace));
  return result;
}

Judge::Judge(robot::Robot robot) : impl_(std::make_unique<Impl>(std::move(robot))) {}
Judge::~Judge() = default;
Judge::Judge(Judge&&) noexcept = default;
Judge& Judge::operator=(Judge&&) noexcept = default;

const robot::Robot& Judge::robot() const { return impl_->robot; }

namespace {

/// Why the motion cannot be judged at all, or nothing.
std::string unjudgeable(const robot::Robot& robot, const JudgeRequest& request) {
  if (request.q.cwiseAbs().maxCoeff() > kAbsurdAngle) return "the plan has a joint angle beyond 1000 rad";
  Eigen::VectorXd start = robot.home();
  const auto& given = request.scenario.robot_start;
  if (!given.empty()) start = Eigen::Map<const Eigen::VectorXd>(given.data(), static_cast<Eigen::Index>(given.size()));
  const double off = (request.q.row(0).transpose() - start).cwiseAbs().maxCoeff();
  if (off > kStartTolerance) return "the plan starts " + number(off) + " rad away from where the robot is";
  return {};
}

/// What the path touches first, and when; also says it in the reason.
std::optional<std::string> first_touched(const robot::Robot& robot, const JudgeRequest& request,
                                         const std::string& target) {
  auto pairs = clearance_pairs(request.scenario, target);
  const auto held = held_shape(robot, request.scenario);
  ClearanceQuery scene(robot, pairs, held);
  const auto hand_pairs = target_pairs(request.scenario, target);
  ClearanceQuery hand(robot, hand_pairs, held);
  const auto a = scene.first_below(request.q, request.settings.clearance_margin);
  // A held object that comes down on its support too deep is stopped there; before that it knocks the support over.
  const auto b = held ? hand.first_below(set_down(robot, request.scenario, request.settings, request.q).approach,
                                         ClearanceQuery::kTolerance)
                      : hand.first_below(request.q, request.settings.target_margin);
  if (b && (!a || b->step < a->step)) return held ? request.scenario.action[2] : target;
  if (a) return pairs[static_cast<std::size_t>(a->pair)].obstacle.name;
  return std::nullopt;
}

void fill_criteria(const std::vector<Criterion>& found, Verdict& verdict) {
  verdict.path_clean = true;
  const auto table = criteria();
  for (std::size_t i = 0; i < found.size(); ++i) verdict.path_clean &= found[i].met || !table[i].strict;
  verdict.criteria = found;
  verdict.clearance = found[0].value;
  verdict.target_clearance = found[1].value;
  verdict.limit_margin = found[2].value;
  verdict.max_speed = found[3].value;
  verdict.path_length = found[4].value;
}

/// on(X, Y) of a place is what the settings' criterion says.
void say_whether_on(const scene::Scenario& scenario, Verdict& verdict) {
  const std::string &x = scenario.action[1], &y = scenario.action[2];
  if (verdict.final_pose_success) {
    std::erase_if(verdict.after, [&](const symbols::Literal& literal) {
      return (literal.predicate == "on" || literal.predicate == "inhand") && literal.arguments[0] == x;
    });
    verdict.after.insert({"on", {x, y}});
  } else {
    verdict.after.erase({"on", {x, y}});
  }
}

}  // namespace

Result<Verdict> Judge::evaluate(const JudgeRequest& asked, Recording* recording) const {
  const auto& robot = impl_->robot;
  PRIMO_TRY(check_request(robot, asked));
  const bool place = asked.scenario.held.has_value();
  std::optional<JudgeRequest> changed;
  if (place) changed = with_fingers_held(robot, asked);
  const JudgeRequest& request = changed ? *changed : asked;
  const std::string name = request.scenario.action[1];
  const scene::Object& target = *request.scenario.object(name);
  Verdict verdict;
  verdict.objects.push_back(request.scenario.table.name);
  for (const auto& object : request.scenario.objects) verdict.objects.push_back(object.name);
  verdict.before = symbols::observe(snapshot(request.scenario));
  verdict.after = verdict.before;
  if (verdict.reason = unjudgeable(robot, request); !verdict.reason.empty()) return verdict;

  fill_criteria(evaluate_criteria({robot, request.scenario, name, request.q, request.dt, request.planner_iterations,
                                   request.settings}),
                verdict);
  const Eigen::VectorXd q_end = request.q.row(request.q.rows() - 1).transpose();
  const robot::Kinematics kinematics = robot.forward(q_end);
  verdict.position_error = place ? place_error(robot, request)
                                 : (robot.pose(kinematics, robot.grasp_frame()).translation() - target.position).norm();

  TrialResult trial;
  std::optional<symbols::WorldSnapshot> world;  // at the end, when all of the scene was simulated
  if (request.mode == Mode::execute) {
    PRIMO_ASSIGN(Execution execution, execute(robot, request, name, verdict.position_error, recording));
    trial = std::move(execution.trial);
    world = std::move(execution.world);
    verdict.contacts = execution.contacts.contacts();
    verdict.unlisted_contacts = execution.contacts.unlisted();
  } else if (place) {
    PRIMO_ASSIGN(Execution execution, impl_->places.run(request, q_end));
    trial = std::move(execution.trial);
    world = std::move(execution.world);
  } else {
    PRIMO_ASSIGN(trial, impl_->final_pose(request, target, verdict));
  }
  verdict.outcome = trial.outcome;
  verdict.score = trial.score;
  verdict.displacement = trial.displacement;
  verdict.survival = trial.survival;
  verdict.steps = trial.steps;
  verdict.criteria.insert(verdict.criteria.end(), trial.criteria.begin(), trial.criteria.end());
  verdict.final_pose_success = trial.outcome == Outcome::held || trial.outcome == Outcome::placed;
  verdict.success = verdict.final_pose_success && verdict.path_clean;
  verdict.reason = trial.reason;

  Aftermath aftermath;
  aftermath.held = verdict.success;
  if (!verdict.path_clean) {
    verdict.reason += "; the path is not clean: " + complaint(verdict.criteria);
    if (!verdict.criteria[2].met) verdict.reason += "; " + first_beyond_limits(robot, request);
    const bool refused = !verdict.criteria[2].met || !verdict.criteria[3].met;
    if (!verdict.criteria[0].met || !verdict.criteria[1].met) {
      const auto touched = first_touched(robot, request, name);
      if (touched) verdict.reason += "; it touches " + *touched + " first";
      if (!refused) aftermath.knocked = touched;
    }
  } else if (trial.steps > 0 && trial.outcome != Outcome::unstable) {
    aftermath.X_WO_target = kinematics.X_WB[static_cast<std::size_t>(robot.tool_body())] * trial.X_PO;
  }
  const bool simulated = world && (request.mode == Mode::execute || verdict.path_clean);
  if (!simulated) world = snapshot_after(request.scenario, name, aftermath);
  verdict.after = symbols::observe(*world);
  if (place && simulated) say_whether_on(request.scenario, verdict);
  return verdict;
}

}  // namespace primo::physics

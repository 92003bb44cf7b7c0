#include "physics/place_trial.h"

#include <algorithm>
#include <cmath>

#include "physics/aftermath.h"
#include "physics/path_clearance.h"
#include "robot/distance.h"

namespace primo::physics {
namespace {

constexpr const char* kHand = "primo:hand";
constexpr double kHangSeconds = 0.05;   // between the grip and the opening
constexpr double kStillSeconds = 0.05;  // at rest for so long: nothing will change
constexpr double kHandArmature = 1e5;   // kg: what the hand touches does not slow it
constexpr double kDepthTolerance = 1e-4;

/// One trial's simulation.
class Trial {
 public:
  Trial(const robot::Robot& robot, PlaceWorkspace& workspace, const JudgeRequest& request, const Eigen::VectorXd& q)
      : robot_(robot),
        w_(workspace),
        m_(workspace.model.get()),
        d_(workspace.data.get()),
        request_(request),
        observer_(request.scenario, workspace.joints, workspace.bodies),
        held_(q.tail(robot.hand_joints())) {
    const Pose X_WG = robot.pose(robot.forward(q), robot.grasp_frame());
    X_WX_ = X_WG * request.scenario.held->X_GO();
    planned_ = stacking(request.scenario, X_WX_, support_pose(request.scenario));
    reset(q);
  }

  const Stacking& planned() const { return planned_; }

  /// Closes the fingers on the pinned object until they rest, then lets it hang. False: diverged.
  bool grip() {
    w_.pin.hold(m_, d_);
    const int patience = count(0.03);
    int still = 0;
    for (int k = count(request_.settings.close_seconds); k > 0 && still < patience; --k) {
      mj_step1(m_, d_);
      w_.joints.close(robot_, d_, held_);
      if (!advance(0)) return false;
      double fastest = 0;
      for (int i = 0; i < m_->nv; ++i) {
        if (i != w_.slide) fastest = std::max(fastest, std::abs(d_->qvel[i]));
      }
      still = fastest < 2e-3 ? still + 1 : 0;
    }
    mj_forward(m_, d_);
    targets_ = w_.joints.frozen_targets(robot_, d_, held_);
    w_.pin.release(m_, d_);
    for (int k = count(kHangSeconds); k > 0; --k) {
      if (!held_step(targets_, 0)) return false;
    }
    mj_forward(m_, d_);
    X_PX_ = body_pose(d_, w_.hand_body).inverse(Eigen::Isometry) * body_pose(d_, w_.bodies.object_body);
    return true;
  }

  /// Opens, retreats, waits for rest. False: diverged.
  bool release() {
    m_->opt.enableflags |= mjENBL_MULTICCD;  // stacked cylinders rock for ever without it
    const int opening = count(kOpenSeconds), retreating = count(kRetreatSeconds), resting = count(kRestSeconds);
    for (int k = 0; k < opening + retreating; ++k) {
      const double t = k * request_.settings.timestep, x = std::max(0.0, t - kOpenSeconds) / kRetreatSeconds;
      if (!held_step(opening_targets(robot_, targets_, t), kRetreat / kRetreatSeconds * 6 * x * (1 - x))) return false;
    }
    const Eigen::VectorXd open = opening_targets(robot_, targets_, kOpenSeconds);
    int still = 0;
    for (int k = 0; k < resting && still < count(kStillSeconds); ++k) {
      if (!held_step(open, 0)) return false;
      still = observer_.speed(m_, d_) < 0.1 * request_.settings.place_speed ? still + 1 : 0;
    }
    for (int k = count(kContactSeconds); k > 0; --k) {
      if (!held_step(open, 0)) return false;
      observer_.note_contacts(m_, d_);
    }
    mj_forward(m_, d_);
    return true;
  }

  PlaceEnd end() const {
    PlaceEnd end = observer_.end(m_, d_);
    end.planned = planned_;
    return end;
  }
  const Pose& X_PX() const { return X_PX_; }
  int steps() const { return steps_; }

  symbols::WorldSnapshot world() const {
    symbols::WorldSnapshot world = snapshot(request_.scenario);
    world.in_hand.clear();
    for (auto& body : world.bodies) {
      const int id = w_.model.body(body.name);
      if (body.kind != symbols::BodyKind::table && id > 0) body.X_WB = body_pose(d_, id);
    }
    return world;
  }

 private:
  int count(double seconds) const { return static_cast<int>(std::lround(seconds / request_.settings.timestep)); }

  void reset(const Eigen::VectorXd& q) {
    m_->opt.enableflags &= ~static_cast<int>(mjENBL_MULTICCD);
    Pose X_WP = palm_pose(robot_, q);
    // The arm yields: an object that a plan puts a little into its support starts as high as to touch it.
    const double lift = clear_height();
    X_WP.translation().z() += lift;
    const Eigen::Quaterniond R = quaternion(X_WP);
    Eigen::Map<Eigen::Vector3d>(m_->body_pos + 3 * w_.hand_body) = X_WP.translation();
    mjtNum* quat = m_->body_quat + 4 * w_.hand_body;
    quat[0] = R.w(), quat[1] = R.x(), quat[2] = R.y(), quat[3] = R.z();
    mj_resetData(m_, d_);
    w_.bystanders.rest(m_, d_);
    w_.joints.set(d_, q);
    for (const auto& object : request_.scenario.objects) {
      Pose X = object.X_WO();
      if (request_.scenario.holds(object.name)) {
        X = X_WX_;
        X.translation().z() += lift;
      }
      set_free_joint(m_, d_, w_.model.joint(object.name), X);
    }
  }

  /// How far up the held object is clear of everything else, m; bisected, at most twice the permitted depth.
  double clear_height() const {
    const auto& scenario = request_.scenario;
    const Shape shape = scenario.object(scenario.held->object)->shape();
    const auto others = obstacles(scenario, scenario.held->object);
    const auto clear = [&](double up) {
      Pose X = X_WX_;
      X.translation().z() += up;
      return std::none_of(others.begin(), others.end(), [&](const Obstacle& other) {
        return robot::distance(shape, X, other.shape, other.X_WO).distance < 0;
      });
    };
    if (clear(0)) return 0;
    double low = 0, high = 2 * request_.settings.max_penetration;
    while (high - low > kDepthTolerance) (clear(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
    return high;
  }

  bool held_step(const Eigen::VectorXd& targets, double speed) {
    mj_step1(m_, d_);
    for (int i = 0; i < robot_.hand_joints(); ++i) w_.joints.servo(robot_, d_, i, targets[i]);
    return advance(speed);
  }

  /// speed: of the hand along its slide, m/s.
  bool advance(double speed) {
    d_->qvel[w_.slide] = speed;
    w_.bystanders.wake_touched(m_, d_);
    mj_step2(m_, d_);
    ++steps_;
    return !diverged(d_);
  }

  const robot::Robot& robot_;
  PlaceWorkspace& w_;
  mjModel* m_;
  mjData* d_;
  const JudgeRequest& request_;
  PlaceObserver observer_;
  Eigen::VectorXd held_, targets_;
  Pose X_WX_, X_PX_ = Pose::Identity();
  Stacking planned_;
  int steps_ = 0;
};

/// What the held object is deepest inside of at X_WX, and how deep, m.
std::pair<std::string, double> deepest_overlap(const scene::Scenario& scenario, const Pose& X_WX) {
  std::pair<std::string, double> deepest;
  const Shape shape = scenario.object(scenario.held->object)->shape();
  for (const auto& other : obstacles(scenario, scenario.held->object)) {
    const double depth = -robot::distance(shape, X_WX, other.shape, other.X_WO).distance;
    if (depth > deepest.second) deepest = {other.name, depth};
  }
  return deepest;
}

/// What the model depends on: everything but where the movable objects are.
std::string key_of(const scene::Scenario& scenario, double timestep) {
  scene::Scenario content;
  content.table = scenario.table;
  content.action = scenario.action;
  content.objects = scenario.objects;
  for (auto& object : content.objects) object.position = object.rpy = Eigen::Vector3d::Zero();
  return std::to_string(timestep) + config::dump(content);
}

void report_end(const Trial& trial, const JudgeSettings& settings, TrialResult& result) {
  const PlaceEnd end = trial.end();
  const PlaceDecision decision = decide_place(end, settings);
  result.outcome = decision.outcome;
  result.reason = decision.reason;
  result.score = decision.score;
  result.criteria = place_criteria(end, settings);
}

}  // namespace

Result<PlaceWorkspace> PlaceWorkspace::create(const robot::Robot& robot, const HandMjcf& hand,
                                              const scene::Scenario& scenario, double timestep) {
  // Compiled with the objects in a row: the bits of a model must not depend on whose request it was made for.
  scene::Scenario row = scenario;
  for (std::size_t i = 0; i < row.objects.size(); ++i) {
    row.objects[i].position = {static_cast<double>(i), 0, 0};
    row.objects[i].rpy.setZero();
  }
  const robot::Kinematics home = robot.forward(robot.home());
  const Eigen::Vector3d back_P =
      -(palm_pose(robot, robot.home()).linear().transpose() * robot.pose(home, robot.grasp_frame()).linear().col(2));
  AssembleOptions options;
  options.timestep = timestep;
  options.extra =
      "  <compiler angle=\"radian\" autolimits=\"true\" boundmass=\"1e-6\" boundinertia=\"1e-10\"/>\n  <worldbody>\n   "
      " <body name=\"" +
      std::string(kHand) + "\">\n      <joint name=\"" + kHand + "\" type=\"slide\" axis=\"" + numbers(back_P) +
      "\" armature=\"" + numbers(&kHandArmature, 1) + "\"/>\n" + hand.bodies +
      "    </body>\n  </worldbody>\n  <equality>\n" + hand.equalities + "  </equality>\n" + hand.tendons;
  PlaceWorkspace w;
  PRIMO_ASSIGN(w.model, assemble(nullptr, row, options));
  w.data = Data(w.model);
  w.joints = JointMap(robot, w.model.get());
  w.bodies = PlaceBodies(w.model, scenario);
  w.hand_body = w.model.body(kHand);
  PRIMO_CHECK(w.hand_body > 0 && w.model.joint(kHand) >= 0, "the place model holds the hand");
  w.slide = w.model->jnt_dofadr[w.model.joint(kHand)];
  w.pin = Pin(w.model, w.model.joint(scenario.held->object));
  w.bystanders = Bystanders(w.model, scenario);
  return w;
}

Result<std::unique_ptr<PlaceWorkspace>> PlaceTrials::take(const std::string& key, const JudgeRequest& request) {
  HandMjcf hand;
  {
    const std::lock_guard lock(mutex_);
    if (auto found = pool_.find(key); found != pool_.end() && !found->second.empty()) {
      auto workspace = std::move(found->second.back());
      found->second.pop_back();
      --pooled_;
      return workspace;
    }
    if (!hand_) {
      PRIMO_ASSIGN(const Model whole, robot_model(robot_));
      PRIMO_ASSIGN(hand_, hand_mjcf(robot_, whole.get()));
    }
    hand = *hand_;
  }
  PRIMO_ASSIGN(auto made, PlaceWorkspace::create(robot_, hand, request.scenario, request.settings.timestep));
  return std::make_unique<PlaceWorkspace>(std::move(made));
}

void PlaceTrials::give_back(const std::string& key, std::unique_ptr<PlaceWorkspace> workspace) {
  constexpr std::size_t kMostPooled = 32;
  const std::lock_guard lock(mutex_);
  if (pooled_ >= kMostPooled) {
    pool_.clear();
    pooled_ = 0;
  }
  pool_[key].push_back(std::move(workspace));
  ++pooled_;
}

Result<Execution> PlaceTrials::run(const JudgeRequest& request, const Eigen::VectorXd& q) {
  Execution execution;
  execution.world = snapshot(request.scenario);
  const Pose X_WX = robot_.pose(robot_.forward(q), robot_.grasp_frame()) * request.scenario.held->X_GO();
  if (const auto [name, depth] = deepest_overlap(request.scenario, X_WX); depth > request.settings.max_penetration) {
    PlaceEnd end;
    end.planned = end.found = stacking(request.scenario, X_WX, support_pose(request.scenario));
    auto& result = execution.trial;
    result.outcome = Outcome::initial_penetration;
    result.reason = "at the final pose the held object is " +
                    std::to_string(static_cast<int>(std::lround(1e3 * depth))) + " mm inside " + name;
    result.score = place_score(end.planned, request.settings);
    result.criteria = place_criteria(end, request.settings);
    return execution;
  }
  const std::string key = key_of(request.scenario, request.settings.timestep);
  PRIMO_ASSIGN(auto workspace, take(key, request));
  {
    Trial trial(robot_, *workspace, request, q);
    auto& result = execution.trial;
    if (!trial.grip() || !trial.release()) {
      result.outcome = Outcome::unstable;
      result.reason = "the simulation diverged";
    } else {
      report_end(trial, request.settings, result);
      const Pose X_PX = palm_pose(robot_, q).inverse(Eigen::Isometry) * X_WX;
      result.displacement = (trial.X_PX().translation() - X_PX.translation()).norm();
      execution.world = trial.world();
    }
    result.X_PO = trial.X_PX();
    result.steps = trial.steps();
  }
  give_back(key, std::move(workspace));
  return execution;
}

}  // namespace primo::physics

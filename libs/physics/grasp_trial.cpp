#include "physics/grasp_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace primo::physics {
namespace {

constexpr double kGravity = 9.81;
constexpr double kRampSeconds = 0.1;     // gravity comes on after the release
constexpr double kSettleSeconds = 0.05;  // before the shaking
constexpr double kMostPush = 0.02;       // m by which coupled fingers may push the object into their middle
constexpr double kContactWindow = 0.05;  // s at the end in which contact counts: a shaken contact flickers

/// Whether a joint that closes moves more than one finger: those meet in their middle, wherever the object is.
bool coupled_fingers(const robot::Robot& robot) {
  const std::vector<int> finger = finger_of_body(robot);
  std::vector<int> mover(static_cast<std::size_t>(robot.joints()), -1);  // by joint of q: a finger that it moves
  for (const auto& joint : robot.chain()) {
    const int hand_joint = joint.index - robot.arm_joints(), moved = finger[static_cast<std::size_t>(joint.body)];
    if (hand_joint < 0 || moved < 0 || robot.file().hand[static_cast<std::size_t>(hand_joint)].closing == 0) continue;
    int& first = mover[static_cast<std::size_t>(joint.index)];
    if (first >= 0 && first != moved) return true;
    first = moved;
  }
  return false;
}

/// A pinned object that can be pushed, against a drag as that of a table, but neither turned nor thrown.
class Drag {
 public:
  /// @pre `pin` holds the object of this free joint, and does so until the end of this.
  Drag(mjModel* model, mjData* data, const Pin& pin, int joint) : model_(model), dof_(model->jnt_dofadr[joint]) {
    constexpr mjtNum kDrag = 100;  // N·s/m: fingers of 10 … 60 N push at 0.1 … 0.6 m/s, and it coasts less than 2 mm
    pin.release(model, data);
    std::array<mjtNum, 3> inertia{}, armature{};
    std::copy_n(model->dof_M0 + dof_, 3, inertia.begin());
    std::copy_n(model->dof_armature + dof_, 3, armature.begin());
    std::copy_n(model->dof_damping + dof_, 3, damping_.begin());
    pin.hold(model, data);
    std::copy_n(inertia.begin(), 3, model->dof_M0 + dof_);
    std::copy_n(armature.begin(), 3, model->dof_armature + dof_);
    std::fill_n(model->dof_damping + dof_, 3, kDrag);
  }
  ~Drag() { std::copy_n(damping_.begin(), 3, model_->dof_damping + dof_); }
  Drag(const Drag&) = delete;
  Drag& operator=(const Drag&) = delete;

 private:
  mjModel* model_;
  int dof_;
  std::array<mjtNum, 3> damping_{};
};

/// One trial's simulation: the stages share the clock, the checks and the shaker.
class Trial {
 public:
  Trial(const robot::Robot& robot, HandWorkspace& workspace, const Pose& X_WP, const JudgeSettings& settings,
        std::uint64_t seed)
      : robot_(robot),
        w_(workspace),
        m_(workspace.model.get()),
        d_(workspace.data.get()),
        gravity_N_(X_WP.linear().transpose() * Eigen::Vector3d(0, 0, -kGravity)),
        settings_(settings),
        shaker_(seed, settings.jiggle_frequency, settings.jiggle_translation, settings.jiggle_rotation,
                settings.timestep) {}

  void reset(const Eigen::VectorXd& q, const Pose& X_PO) {
    mj_resetData(m_, d_);
    w_.joints.set(d_, q);
    set_free_joint(m_, d_, w_.object_joint, X_PO);
    held_ = q.tail(robot_.hand_joints());
    w_.pin.hold(m_, d_);
  }

  bool close() {
    // Fingers that have stopped have closed: nothing changes after that while the object is pinned.
    const int steps = count(settings_.close_seconds), patience = count(0.03);
    int still = 0;
    for (int k = 0; k < steps && still < patience; ++k) {
      mj_step1(m_, d_);
      apply_frame_forces(m_, d_, {}, w_.centre, Eigen::Vector3d::Zero());
      w_.joints.close(robot_, d_, held_);
      if (!advance()) return false;
      double fastest = 0;  // rad/s; slides as the tip of a hinged finger
      for (int i = 0; i < m_->nv; ++i) {
        const double unit = m_->jnt_type[m_->dof_jntid[i]] == mjJNT_SLIDE ? kFingerLength : 1.0;
        fastest = std::max(fastest, std::abs(d_->qvel[i]) / unit);
      }
      still = fastest < 2e-3 ? still + 1 : 0;
    }
    mj_forward(m_, d_);
    return true;
  }

  /// Fingers that one drive couples meet in their middle, and an object that stands off it is pushed there by the first
  /// finger that touches, which drags it over the table. False when the simulation diverged.
  bool push_between() {
    const Pose X_PO = object();
    const Drag drag(m_, d_, w_.pin, w_.object_joint);
    if (!close()) return false;
    pushed_too_far_ = (object().translation() - X_PO.translation()).norm() > kMostPush;
    return true;
  }
  bool pushed_too_far() const { return pushed_too_far_; }

  void release() {
    targets_ = w_.joints.frozen_targets(robot_, d_, held_);
    w_.pin.release(m_, d_);
    p_start_ = object_position();
  }

  enum class Stop { none, fell, diverged };

  /// Lets gravity come and the object settle, hand still.
  Stop settle() {
    const int steps = count(kRampSeconds + kSettleSeconds);
    for (int k = 0; k < steps; ++k) {
      const double gravity = std::min(1.0, k * settings_.timestep / kRampSeconds);
      if (const Stop stop = held_step({}, gravity * gravity_N_); stop != Stop::none) return stop;
    }
    return Stop::none;
  }

  Stop shake() {
    const int steps = count(settings_.jiggle_seconds), window = count(kContactWindow);
    for (shaken_ = 0; shaken_ < steps; ++shaken_) {
      if (const Stop stop = held_step(shaker_.next(), gravity_N_); stop != Stop::none) return stop;
      if (shaken_ + window >= steps) opposed_at_end_ = opposed_at_end_ || grip().opposed();
    }
    if (steps == 0) opposed_at_end_ = grip().opposed();
    return Stop::none;
  }

  Grip grip() const { return w_.joints.grip(m_, d_, w_.object_geom); }
  bool opposed_at_end() const { return opposed_at_end_; }
  const char* holders() const { return w_.joints.holders(); }
  double displacement() const { return displacement_; }
  int steps() const { return steps_; }
  double timestep() const { return settings_.timestep; }
  double survival() const {
    const int steps = count(settings_.jiggle_seconds);
    return steps > 0 ? static_cast<double>(shaken_) / steps : 1.0;
  }
  Pose object() const { return body_pose(d_, w_.object_body); }

 private:
  int count(double seconds) const { return static_cast<int>(std::lround(seconds / settings_.timestep)); }

  bool advance() {
    mj_step2(m_, d_);
    ++steps_;
    return !diverged(d_);
  }

  Stop held_step(const ShakerState& shaker, const Eigen::Vector3d& gravity) {
    mj_step1(m_, d_);
    apply_frame_forces(m_, d_, shaker, w_.centre, gravity);
    for (int i = 0; i < robot_.hand_joints(); ++i) w_.joints.servo(robot_, d_, i, targets_[i]);
    if (!advance()) return Stop::diverged;
    displacement_ = std::max(displacement_, (object_position() - p_start_).norm());
    return displacement_ > settings_.max_displacement ? Stop::fell : Stop::none;
  }

  Eigen::Vector3d object_position() const {
    return Eigen::Map<const Eigen::Vector3d>(d_->qpos + m_->jnt_qposadr[w_.object_joint]);
  }

  const robot::Robot& robot_;
  HandWorkspace& w_;
  mjModel* m_;
  mjData* d_;
  Eigen::Vector3d gravity_N_;  // in the hand's nominal frame
  const JudgeSettings& settings_;
  Shaker shaker_;
  Eigen::VectorXd held_, targets_;
  Eigen::Vector3d p_start_{0, 0, 0};
  double displacement_ = 0;
  int steps_ = 0, shaken_ = 0;
  bool opposed_at_end_ = false, pushed_too_far_ = false;
};

TrialResult diverged_result(const Trial& trial) {
  TrialResult result;
  result.outcome = Outcome::unstable;
  result.reason = "the simulation of hand and object diverged" + unstable_at(trial.steps(), trial.timestep());
  result.steps = trial.steps();
  return result;
}

/// The stages after the closing: what became of an object that thumb and finger held.
TrialResult shake_object(Trial& trial, const JudgeSettings& settings) {
  TrialResult result;
  trial.release();
  Trial::Stop stop = trial.settle();
  if (stop == Trial::Stop::fell) {
    result.outcome = Outcome::fell_at_release;
    result.reason = "the object slipped out of the closed fingers when it was let go";
    result.score = 0.4;
  } else if (stop == Trial::Stop::none) {
    stop = trial.shake();
    result.survival = trial.survival();
    if (stop == Trial::Stop::fell) {
      result.outcome = Outcome::fell_in_jiggle;
      result.reason = "the object moved more than " +
                      std::to_string(static_cast<int>(std::lround(settings.max_displacement * 1e3))) +
                      " mm in the shaken hand after " +
                      std::to_string(static_cast<int>(std::lround(result.survival * 100))) + " % of the jiggle";
      result.score = 0.4 + 0.4 * result.survival;
    } else if (!trial.opposed_at_end()) {
      result.outcome = Outcome::contact_lost;
      result.reason = std::string("after the jiggle ") + trial.holders() + " no longer held the object between them";
      result.score = 0.8;
    } else {
      result.outcome = Outcome::held;
      result.reason = "the object stayed in the shaken hand";
      result.score = 1.0 - 0.2 * std::min(1.0, trial.displacement() / settings.max_displacement);
    }
  }
  if (stop == Trial::Stop::diverged) return diverged_result(trial);
  result.displacement = trial.displacement();
  return result;
}

}  // namespace

std::string unstable_at(int steps, double timestep) {
  char text[64];
  std::snprintf(text, sizeof text, " at step %d (%.4g s)", steps, steps * timestep);
  return text;
}

double miss_score(double position_error) { return 0.25 * std::exp(-position_error / 0.05); }

double penetration_score(double position_error, double penetration, double limit) {
  return miss_score(position_error) * std::exp(-std::max(0.0, penetration - limit) / 0.01);
}

Result<HandWorkspace> HandWorkspace::create(const robot::Robot& robot, const mjModel* whole, const Shape& object,
                                            double mass, double timestep) {
  HandWorkspace w;
  PRIMO_ASSIGN(w.model, hand_model(robot, whole, object, mass, timestep));
  w.data = Data(w.model);
  w.joints = JointMap(robot, w.model.get());
  const Eigen::VectorXd& home = robot.home();
  w.centre = palm_pose(robot, home).inverse(Eigen::Isometry) *
             robot.pose(robot.forward(home), robot.grasp_frame()).translation();
  w.object_body = w.model.body(kHandObject);
  w.object_geom = w.model.geom(kHandObject);
  w.object_joint = w.model.joint(kHandObject);
  PRIMO_CHECK(w.object_body >= 0 && w.object_geom >= 0 && w.object_joint >= 0, "the hand model holds its object");
  w.pin = Pin(w.model, w.object_joint);
  return w;
}

TrialResult run_trial(const robot::Robot& robot, HandWorkspace& workspace, const Eigen::VectorXd& q, const Pose& X_WP,
                      const Pose& X_WO, double position_error, const JudgeSettings& settings, std::uint64_t seed) {
  Trial trial(robot, workspace, X_WP, settings, seed);
  const Pose X_PO = X_WP.inverse(Eigen::Isometry) * X_WO;
  trial.reset(q, X_PO);
  if (!trial.close()) return diverged_result(trial);
  Grip grip = trial.grip();
  if (grip.parts() > 0 && !grip.opposed() && coupled_fingers(robot)) {
    if (!trial.push_between()) return diverged_result(trial);
    grip = trial.grip();
  }
  TrialResult result;
  if (grip.parts() == 0) {
    result.outcome = Outcome::no_contact;
    result.reason = "the closed fingers do not touch the object";
    result.score = miss_score(position_error);
  } else if (!grip.opposed() || trial.pushed_too_far()) {
    result.outcome = Outcome::not_opposed;
    result.reason =
        grip.opposed() ? "the fingers push the object by more than 20 mm before both hold it" : grip.complaint();
    result.score = 0.25 + 0.05 * grip.parts();
  } else {
    result = shake_object(trial, settings);
  }
  result.steps = trial.steps();
  result.X_PO = result.outcome == Outcome::unstable ? X_PO : trial.object();
  return result;
}

}  // namespace primo::physics

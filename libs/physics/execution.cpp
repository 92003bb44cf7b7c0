#include "physics/execution.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/aftermath.h"

namespace primo::physics {
namespace {

constexpr double kSettleSeconds = 0.1;
constexpr double kLiftSeconds = 1.0;
constexpr double kLiftHeight = 0.1;  // m
constexpr double kHoldSeconds = 0.5;
constexpr double kLifted = 0.02;  // m above where it stood: carried by the hand, not by the table

struct Reference {
  Eigen::VectorXd q, velocity, acceleration;
  int step = 0;  ///< of the plan
};

/// Cubic Hermite interpolation of the rows of q with central differences as slopes; at rest at both ends.
Reference reference_at(const Eigen::MatrixXd& q, double dt, double time) {
  const Eigen::Index last = q.rows() - 1;
  const double position = std::clamp(time / dt, 0.0, static_cast<double>(last));
  const Eigen::Index t = std::min(static_cast<Eigen::Index>(position), last - 1);
  const double s = position - static_cast<double>(t);
  const auto slope = [&](Eigen::Index k) -> Eigen::VectorXd {
    if (k <= 0 || k >= last) return Eigen::VectorXd::Zero(q.cols());
    return 0.5 * (q.row(k + 1) - q.row(k - 1)).transpose();
  };
  const Eigen::VectorXd a = q.row(t).transpose(), b = q.row(t + 1).transpose(), va = slope(t), vb = slope(t + 1);
  const Eigen::VectorXd c2 = 3 * (b - a) - 2 * va - vb, c3 = 2 * (a - b) + va + vb;
  Reference r;
  r.q = a + s * (va + s * (c2 + s * c3));
  r.velocity = (va + s * (2 * c2 + 3 * s * c3)) / dt;
  r.acceleration = (2 * c2 + 6 * s * c3) / (dt * dt);
  r.step = static_cast<int>(t);
  if (time < 0 || time >= dt * static_cast<double>(last)) {
    r.velocity.setZero();
    r.acceleration.setZero();
  }
  return r;
}

/// The damped least-squares step of the arm's joints for J dq = error that keeps their limits: a joint that would pass
/// one stands still, and the others make up for it.
Eigen::VectorXd limited_step(const robot::Robot& robot, const Eigen::VectorXd& q, Eigen::MatrixXd J,
                             const Eigen::VectorXd& error) {
  constexpr double kDamping = 3e-4;  // m²: directions in which a radian moves the hand by less than 2 cm are left alone
  constexpr double kLargestStep = 0.02;  // rad
  const Eigen::Index arm = J.cols();
  Eigen::VectorXd step;
  for (Eigen::Index pass = 0; pass < arm; ++pass) {
    const Eigen::MatrixXd A = J.transpose() * J + kDamping * Eigen::MatrixXd::Identity(arm, arm);
    step = A.ldlt().solve(J.transpose() * error).cwiseMax(-kLargestStep).cwiseMin(kLargestStep);
    bool kept = true;
    for (Eigen::Index i = 0; i < arm; ++i) {
      const double to = q[i] + step[i];
      if (step[i] == 0 || (to >= robot.lower()[i] && to <= robot.upper()[i])) continue;
      J.col(i).setZero();
      kept = false;
    }
    if (kept) return step;
  }
  return Eigen::VectorXd::Zero(arm);
}

/// Arm configurations that raise the grasp frame from q by `height` in equal parts, its orientation kept: as far as the
/// arm can. Where it cannot, it goes less high, and smoothly: a lift is the judge's motion, and nothing that the plan
/// should be blamed for.
Eigen::MatrixXd lift_path(const robot::Robot& robot, Eigen::VectorXd q, double height, int parts) {
  Eigen::MatrixXd path(parts + 1, q.size());
  path.row(0) = q.transpose();
  robot::Kinematics kinematics = robot.forward(q);
  const Pose X_WG0 = robot.pose(kinematics, robot.grasp_frame());
  const int body = robot.grasp_frame().body, arm = robot.arm_joints();
  for (int part = 1; part <= parts; ++part) {
    const double s = static_cast<double>(part) / parts, raised = height * s * s * (3 - 2 * s);
    for (int iteration = 0; iteration < 5; ++iteration) {
      robot.forward(q, kinematics);
      const Pose X_WG = robot.pose(kinematics, robot.grasp_frame());
      Eigen::Matrix<double, 9, 1> error;
      Eigen::MatrixXd J(9, arm);
      error.head<3>() = X_WG0.translation() + Eigen::Vector3d(0, 0, raised) - X_WG.translation();
      J.topRows(3) = robot.point_jacobian(kinematics, body, X_WG.translation()).leftCols(arm);
      for (int axis = 0; axis < 2; ++axis) {
        // Two axes fix the orientation; 0.1 m weighs a radian.
        error.segment<3>(3 + 3 * axis) = 0.1 * (X_WG0.linear().col(axis) - X_WG.linear().col(axis));
        J.middleRows(3 + 3 * axis, 3) =
            0.1 * robot.vector_jacobian(kinematics, body, X_WG.linear().col(axis)).leftCols(arm);
      }
      q.head(arm) += limited_step(robot, q, std::move(J), error);
    }
    path.row(part) = q.transpose();
  }
  return path;
}

class Simulation {
 public:
  Simulation(const robot::Robot& robot, const JudgeRequest& request, Model model, const std::string& target,
             Recording* recording)
      : robot_(robot),
        request_(request),
        recording_(recording),
        model_(std::move(model)),
        data_(model_),
        m_(model_.get()),
        d_(data_.get()),
        joints_(robot, m_),
        object_body_(model_.body(target)),
        object_geom_(model_.geom("object:" + target)) {
    // The judge drives the joints by torques from the robot file; the model's own actuators stay off.
    m_->opt.disableflags |= mjDSBL_ACTUATION;
    // The arm's derivative gains act as joint damping, which Euler integrates implicitly: as explicit torques they
    // would ring.
    for (int i = 0; i < robot.arm_joints(); ++i) {
      m_->dof_damping[joints_.dof(i)] += robot.file().arm[static_cast<std::size_t>(i)].kd;
    }
    palm_ = mj_name2id(m_, mjOBJ_JOINT, robot.file().arm.back().joint.c_str());
    palm_ = m_->jnt_bodyid[palm_];
    q_ = request.q.row(0).transpose();
    velocity_ = Eigen::VectorXd::Zero(q_.size());
    joints_.set(d_, q_);
    mj_forward(m_, d_);
    contacts_ = ContactLog(m_);
  }

  int steps_in(double seconds) const { return static_cast<int>(std::lround(seconds / m_->opt.timestep)); }
  double timestep() const { return m_->opt.timestep; }

  enum class Fingers { follow, close, hold };

  /// One time step towards a reference. False when the simulation diverged.
  bool step(const Reference& reference, Fingers fingers, bool gains) {
    mj_step1(m_, d_);
    joints_.get(d_, q_, velocity_);
    drive_arm(reference, gains);
    const Eigen::VectorXd planned = reference.q.tail(robot_.hand_joints());
    if (fingers == Fingers::close) {
      joints_.close(robot_, d_, planned);
    } else {
      for (int i = 0; i < robot_.hand_joints(); ++i)
        joints_.servo(robot_, d_, i, fingers == Fingers::hold ? targets_[i] : planned[i]);
    }
    mj_step2(m_, d_);
    ++steps_;
    if (diverged(d_)) return false;
    contacts_.record(m_, d_, steps_ * timestep());
    if (recording_) keep_frame();
    return true;
  }

  /// From here on all fingers press with their closing torque where they are, as after the trial of a final pose.
  void freeze_fingers(const Eigen::VectorXd& planned) {
    mj_forward(m_, d_);
    targets_ = joints_.frozen_targets(robot_, d_, planned.tail(robot_.hand_joints()));
  }

  void update() { mj_forward(m_, d_); }
  Pose X_PO() const { return body_pose(d_, palm_).inverse(Eigen::Isometry) * body_pose(d_, object_body_); }
  double object_height() const { return d_->xpos[3 * object_body_ + 2]; }
  Grip grip() const { return joints_.grip(m_, d_, object_geom_); }
  double tracking_error(const Reference& r) const {
    const int arm = robot_.arm_joints();
    return (q_.head(arm) - r.q.head(arm)).cwiseAbs().maxCoeff();
  }
  const Eigen::VectorXd& q() const { return q_; }
  int steps() const { return steps_; }
  const ContactLog& contacts() const { return contacts_; }

  symbols::WorldSnapshot world() const {
    symbols::WorldSnapshot world = snapshot(request_.scenario);
    for (auto& body : world.bodies) {
      const int id = model_.body(body.name);
      if (body.kind != symbols::BodyKind::table && id > 0) body.X_WB = body_pose(d_, id);
    }
    return world;
  }

 private:
  void keep_frame() {
    const double time = steps_ * timestep();
    auto& frames = recording_->frames;
    if (!frames.empty() && time < frames.back().time + recording_->interval - 1e-9) return;
    Recording::Frame frame{time, q_, {}};
    for (const auto& object : request_.scenario.objects) frame.X_WO.push_back(body_pose(d_, model_.body(object.name)));
    frames.push_back(std::move(frame));
  }

  void drive_arm(const Reference& r, bool gains) {
    const int arm = robot_.arm_joints();
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(m_->nv), torque = wanted;
    Eigen::VectorXd acceleration = r.acceleration;
    if (gains && !request_.K.empty()) {
      Eigen::VectorXd delta(2 * q_.size());
      delta << q_ - r.q, velocity_ - r.velocity;
      acceleration +=
          request_.K[static_cast<std::size_t>(std::min<int>(r.step, static_cast<int>(request_.K.size()) - 1))] * delta;
    }
    for (int i = 0; i < arm; ++i) wanted[joints_.dof(i)] = acceleration[i];
    mj_mulM(m_, d_, torque.data(), wanted.data());
    for (int i = 0; i < arm; ++i) {
      const auto& spec = robot_.file().arm[static_cast<std::size_t>(i)];
      const int dof = joints_.dof(i);
      // The damping torque of the moving reference; with the model's own damping it makes kd (q̇* − q̇).
      const double total =
          torque[dof] + d_->qfrc_bias[dof] + m_->dof_damping[dof] * r.velocity[i] + spec.kp * (r.q[i] - q_[i]);
      const double limit = spec.max_torque > 0 ? spec.max_torque : std::numeric_limits<double>::infinity();
      d_->qfrc_applied[dof] = std::isfinite(total) ? std::clamp(total, -limit, limit) : 0.0;
    }
  }

  const robot::Robot& robot_;
  const JudgeRequest& request_;
  Recording* recording_;
  Model model_;
  Data data_;
  mjModel* m_;
  mjData* d_;
  JointMap joints_;
  int object_body_, object_geom_, palm_ = 0;
  Eigen::VectorXd q_, velocity_, targets_;
  ContactLog contacts_;
  int steps_ = 0;
};

Execution finish(const Simulation& simulation, Execution execution, Outcome outcome, const std::string& reason,
                 double score) {
  execution.trial.outcome = outcome;
  execution.trial.reason = reason;
  execution.trial.score = score;
  execution.trial.steps = simulation.steps();
  execution.contacts = simulation.contacts();
  if (outcome == Outcome::unstable) {
    execution.trial.reason += unstable_at(simulation.steps(), simulation.timestep());
  } else {
    execution.trial.X_PO = simulation.X_PO();
    execution.world = simulation.world();
  }
  return execution;
}

Reference at_rest(const Eigen::VectorXd& q) {
  return {q, Eigen::VectorXd::Zero(q.size()), Eigen::VectorXd::Zero(q.size()), 0};
}

/// Lifts and holds. The target's displacement in the hand counts from the closing.
Execution lift_and_hold(const robot::Robot& robot, Simulation& simulation, Execution execution,
                        const Eigen::VectorXd& q_end, const JudgeSettings& settings) {
  constexpr int kParts = 20;
  const Eigen::MatrixXd path = lift_path(robot, q_end, kLiftHeight, kParts);
  const Pose X_start = simulation.X_PO();
  const double height = simulation.object_height();
  const int steps = simulation.steps_in(kLiftSeconds + kHoldSeconds), window = simulation.steps_in(0.05);
  bool opposed = false;
  for (int k = 0; k < steps; ++k) {
    const Reference reference = reference_at(path, kLiftSeconds / kParts, k * simulation.timestep());
    if (!simulation.step(reference, Simulation::Fingers::hold, false)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while lifting", 0);
    }
    if (k % 5 != 0 && k + window < steps) continue;
    auto& trial = execution.trial;
    trial.displacement = std::max(trial.displacement, (simulation.X_PO().translation() - X_start.translation()).norm());
    trial.survival = static_cast<double>(k + 1) / steps;
    if (k + window >= steps) opposed = opposed || simulation.grip().opposed();
    if (trial.displacement > settings.max_displacement) {
      return finish(simulation, std::move(execution), Outcome::fell_in_jiggle,
                    "the object slipped out of the hand while it was lifted", 0.4 + 0.4 * trial.survival);
    }
  }
  simulation.update();
  if (!opposed) {
    return finish(simulation, std::move(execution), Outcome::contact_lost,
                  "after lifting thumb and fingers no longer hold the object", 0.8);
  }
  if (simulation.object_height() < height + kLifted) {
    return finish(simulation, std::move(execution), Outcome::contact_lost,
                  "the arm could not lift the object off its support", 0.8);
  }
  const double score = 1.0 - 0.2 * std::min(1.0, execution.trial.displacement / settings.max_displacement);
  return finish(simulation, std::move(execution), Outcome::held, "the object was lifted and held", score);
}

}  // namespace

Result<Execution> execute(const robot::Robot& robot, const JudgeRequest& request, const std::string& target,
                          double position_error, Recording* recording) {
  PRIMO_ASSIGN(Model model, assemble(&robot, request.scenario, {.timestep = request.settings.timestep, .extra = {}}));
  Simulation simulation(robot, request, std::move(model), target, recording);
  Execution execution;
  execution.world = snapshot(request.scenario);
  const double duration = request.dt * static_cast<double>(request.q.rows() - 1);
  const int moving = simulation.steps_in(duration), settling = simulation.steps_in(kSettleSeconds);
  for (int k = 0; k < moving + settling; ++k) {
    const double time = k * simulation.timestep();
    const Reference reference = reference_at(request.q, request.dt, time);
    if (!simulation.step(reference, Simulation::Fingers::follow, true)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while moving", 0);
    }
    execution.tracking_error = std::max(execution.tracking_error, simulation.tracking_error(reference));
  }
  const Eigen::VectorXd q_end = request.q.row(request.q.rows() - 1).transpose();
  for (int k = simulation.steps_in(request.settings.close_seconds); k > 0; --k) {
    if (!simulation.step(at_rest(q_end), Simulation::Fingers::close, false)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while closing", 0);
    }
  }
  simulation.freeze_fingers(q_end);
  const Grip grip = simulation.grip();
  if (grip.parts() == 0) {
    return finish(simulation, std::move(execution), Outcome::no_contact, "the closed fingers do not touch the object",
                  miss_score(position_error));
  }
  if (!grip.opposed()) {
    return finish(simulation, std::move(execution), Outcome::not_opposed,
                  grip.thumb ? "only the thumb touches the object" : "the thumb does not touch the object",
                  0.25 + 0.05 * grip.parts());
  }
  Execution done = lift_and_hold(robot, simulation, std::move(execution), q_end, request.settings);
  if (done.trial.outcome == Outcome::held) done.world.in_hand.insert(target);
  return done;
}

}  // namespace primo::physics

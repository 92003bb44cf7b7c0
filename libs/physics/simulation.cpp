#include "physics/simulation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <utility>

#include "physics/aftermath.h"

namespace primo::physics {

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

Reference at_rest(const Eigen::VectorXd& q) {
  return {q, Eigen::VectorXd::Zero(q.size()), Eigen::VectorXd::Zero(q.size()), 0};
}

namespace {

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

}  // namespace

Eigen::MatrixXd straight_path(const robot::Robot& robot, Eigen::VectorXd q, const Eigen::Vector3d& along, int parts) {
  constexpr int kMostIterations = 25;
  constexpr double kSmallStep = 1e-5;  // rad
  Eigen::MatrixXd path(parts + 1, q.size());
  path.row(0) = q.transpose();
  robot::Kinematics kinematics = robot.forward(q);
  const Pose X_WG0 = robot.pose(kinematics, robot.grasp_frame());
  const int body = robot.grasp_frame().body, arm = robot.arm_joints();
  for (int part = 1; part <= parts; ++part) {
    const double s = static_cast<double>(part) / parts;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      robot.forward(q, kinematics);
      const Pose X_WG = robot.pose(kinematics, robot.grasp_frame());
      Eigen::Matrix<double, 9, 1> error;
      Eigen::MatrixXd J(9, arm);
      error.head<3>() = X_WG0.translation() + along * s * s * (3 - 2 * s) - X_WG.translation();
      J.topRows(3) = robot.point_jacobian(kinematics, body, X_WG.translation()).leftCols(arm);
      for (int axis = 0; axis < 2; ++axis) {
        // Two axes fix the orientation; 0.1 m weighs a radian.
        error.segment<3>(3 + 3 * axis) = 0.1 * (X_WG0.linear().col(axis) - X_WG.linear().col(axis));
        J.middleRows(3 + 3 * axis, 3) =
            0.1 * robot.vector_jacobian(kinematics, body, X_WG.linear().col(axis)).leftCols(arm);
      }
      const Eigen::VectorXd step = limited_step(robot, q, std::move(J), error);
      q.head(arm) += step;
      if (step.cwiseAbs().maxCoeff() < kSmallStep) break;
    }
    path.row(part) = q.transpose();
  }
  return path;
}

double row_seconds(const robot::Robot& robot, const Eigen::MatrixXd& path, double shortest) {
  constexpr double kSlowest = 4;
  double seconds = shortest;
  for (int i = 0; i < robot.arm_joints(); ++i) {
    const double step = (path.col(i).tail(path.rows() - 1) - path.col(i).head(path.rows() - 1)).cwiseAbs().maxCoeff();
    const double speed = robot.file().arm[static_cast<std::size_t>(i)].max_speed;
    if (speed > 0) seconds = std::max(seconds, step / speed);
  }
  return std::min(seconds, kSlowest * shortest);
}

Simulation::Simulation(const robot::Robot& robot, const JudgeRequest& request, Model model, const std::string& object,
                       Recording* recording)
    : robot_(robot),
      request_(request),
      recording_(recording),
      model_(std::move(model)),
      data_(model_),
      m_(model_.get()),
      d_(data_.get()),
      joints_(robot, m_),
      object_body_(model_.body(object)),
      object_geom_(model_.geom("object:" + object)),
      pin_(model_, model_.joint(object)) {
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

bool Simulation::step(const Reference& reference, Fingers fingers, bool gains) {
  mj_step1(m_, d_);
  joints_.get(d_, q_, velocity_);
  drive_arm(reference, fingers, gains);
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

void Simulation::keep_frame() {
  const double time = steps_ * timestep();
  auto& frames = recording_->frames;
  if (!frames.empty() && time < frames.back().time + recording_->interval - 1e-9) return;
  Recording::Frame frame{time, q_, {}};
  for (const auto& object : request_.scenario.objects) frame.X_WO.push_back(body_pose(d_, model_.body(object.name)));
  frames.push_back(std::move(frame));
}

void Simulation::freeze_fingers(const Eigen::VectorXd& planned) {
  mj_forward(m_, d_);
  targets_ = joints_.frozen_targets(robot_, d_, planned.tail(robot_.hand_joints()));
}

void Simulation::pin(bool pinned) {
  if (pinned) {
    pin_.hold(m_, d_);
  } else {
    pin_.release(m_, d_);
  }
}

bool Simulation::still() const {
  constexpr double kStill = 2e-3;
  return std::all_of(d_->qvel, d_->qvel + m_->nv, [](double speed) { return std::abs(speed) < kStill; });
}

double Simulation::tracking_error(const Reference& r) const {
  const int arm = robot_.arm_joints();
  return (q_.head(arm) - r.q.head(arm)).cwiseAbs().maxCoeff();
}

symbols::WorldSnapshot Simulation::world() const {
  symbols::WorldSnapshot world = snapshot(request_.scenario);
  world.in_hand.clear();
  for (auto& body : world.bodies) {
    const int id = model_.body(body.name);
    if (body.kind != symbols::BodyKind::table && id > 0) body.X_WB = body_pose(d_, id);
  }
  return world;
}

void Simulation::drive_arm(const Reference& r, Fingers fingers, bool gains) {
  const int arm = robot_.arm_joints();
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(m_->nv), torque = wanted;
  Eigen::VectorXd acceleration = r.acceleration;
  if (gains && !request_.K.empty()) {
    Eigen::VectorXd delta(2 * q_.size());
    delta << q_ - r.q, velocity_ - r.velocity;
    if (fingers == Fingers::hold) {
      // Fingers that hold something are where it lets them: no error of the motion.
      delta.segment(arm, robot_.hand_joints()).setZero();
      delta.tail(robot_.hand_joints()).setZero();
    }
    acceleration +=
        request_.K[static_cast<std::size_t>(std::min<int>(r.step, static_cast<int>(request_.K.size()) - 1))] * delta;
  }
  for (int i = 0; i < arm; ++i) wanted[joints_.dof(i)] = acceleration[i];
  mj_mulM(m_, d_, torque.data(), wanted.data());
  for (int i = 0; i < arm; ++i) {
    const auto& spec = robot_.file().arm[static_cast<std::size_t>(i)];
    const int dof = joints_.dof(i);
    const double damping = m_->dof_damping[dof];
    // The drive's whole torque is limited, kd (q̇* − q̇) included. −kd q̇ is in the model's damping, so it is added here.
    const double total = torque[dof] + d_->qfrc_bias[dof] + damping * r.velocity[i] + spec.kp * (r.q[i] - q_[i]) -
                         spec.kd * velocity_[i];
    const double limit = spec.max_torque > 0 ? spec.max_torque : std::numeric_limits<double>::infinity();
    const double drive = std::isfinite(total) ? std::clamp(total, -limit, limit) : 0.0;
    d_->qfrc_applied[dof] = drive + spec.kd * velocity_[i];
  }
}

}  // namespace primo::physics

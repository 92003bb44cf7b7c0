#include "physics/joint_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "robot/distance.h"

namespace primo::physics {

std::vector<int> finger_of_body(const robot::Robot& robot) {
  const auto& bodies = robot.bodies();
  std::vector<int> users(bodies.size(), 0), finger(bodies.size(), -1);
  const auto& tips = robot.fingertips();
  for (const auto& tip : tips) {
    for (int b = tip.frame.body; b > 0; b = bodies[static_cast<std::size_t>(b)].parent)
      ++users[static_cast<std::size_t>(b)];
  }
  for (std::size_t t = 0; t < tips.size(); ++t) {
    for (int b = tips[t].frame.body; b > 0; b = bodies[static_cast<std::size_t>(b)].parent) {
      const auto i = static_cast<std::size_t>(b);
      // A one-fingered hand shares nothing: stop at what the arm carries.
      if (users[i] > 1 || !bodies[i].hand) break;
      finger[i] = static_cast<int>(t);
    }
  }
  return finger;
}

JointMap::JointMap(const robot::Robot& robot, const mjModel* model)
    : qpos_(static_cast<std::size_t>(robot.joints()), -1),
      dof_(qpos_),
      finger_of_body_(static_cast<std::size_t>(model->nbody), -1),
      robot_body_(static_cast<std::size_t>(model->nbody), false),
      arm_(robot.arm_joints()) {
  for (const auto& joint : robot.chain()) {
    const int id = mj_name2id(model, mjOBJ_JOINT, joint.name.c_str());
    if (id >= 0)
      slots_.push_back({joint.index, model->jnt_qposadr[id], model->jnt_dofadr[id], joint.offset, joint.ratio});
  }
  for (int i = 0; i < robot.joints(); ++i) {
    const int id = mj_name2id(model, mjOBJ_JOINT, robot.joint_names()[static_cast<std::size_t>(i)].c_str());
    if (id < 0) continue;
    qpos_[static_cast<std::size_t>(i)] = model->jnt_qposadr[id];
    dof_[static_cast<std::size_t>(i)] = model->jnt_dofadr[id];
  }
  const auto fingers = finger_of_body(robot);
  for (std::size_t b = 1; b < fingers.size(); ++b) {
    const int id = mj_name2id(model, mjOBJ_BODY, robot.bodies()[b].name.c_str());
    if (id <= 0) continue;
    finger_of_body_[static_cast<std::size_t>(id)] = fingers[b];
    robot_body_[static_cast<std::size_t>(id)] = true;
  }
  for (const auto& tip : robot.fingertips()) thumb_.push_back(tip.thumb);
}

void JointMap::set(mjData* data, const Eigen::VectorXd& q) const {
  for (const auto& slot : slots_) {
    data->qpos[slot.qpos] = slot.offset + slot.ratio * q[slot.index];
    data->qvel[slot.dof] = 0;
  }
}

void JointMap::get(const mjData* data, Eigen::VectorXd& q, Eigen::VectorXd& velocity) const {
  for (std::size_t i = 0; i < qpos_.size(); ++i) {
    if (qpos_[i] < 0) continue;
    q[static_cast<Eigen::Index>(i)] = data->qpos[qpos_[i]];
    velocity[static_cast<Eigen::Index>(i)] = data->qvel[dof_[i]];
  }
}

void JointMap::servo(const robot::Robot& robot, mjData* data, int hand_joint, double target) const {
  const auto& spec = robot.file().hand[static_cast<std::size_t>(hand_joint)];
  const auto i = static_cast<std::size_t>(arm_ + hand_joint);
  const double torque = spec.kp * (target - data->qpos[qpos_[i]]) - spec.kd * data->qvel[dof_[i]];
  data->qfrc_applied[dof_[i]] = std::clamp(torque, -spec.max_torque, spec.max_torque);
}

void JointMap::close(const robot::Robot& robot, mjData* data, const Eigen::VectorXd& held) const {
  for (int i = 0; i < robot.hand_joints(); ++i) {
    const double torque = robot.file().hand[static_cast<std::size_t>(i)].closing;
    if (torque == 0) {
      servo(robot, data, i, held[i]);
    } else {
      data->qfrc_applied[dof_[static_cast<std::size_t>(arm_ + i)]] = torque;
    }
  }
}

Eigen::VectorXd JointMap::frozen_targets(const robot::Robot& robot, const mjData* data,
                                         const Eigen::VectorXd& held) const {
  Eigen::VectorXd targets = held;
  for (int i = 0; i < robot.hand_joints(); ++i) {
    const auto& spec = robot.file().hand[static_cast<std::size_t>(i)];
    if (spec.closing != 0 && spec.kp > 0) {
      targets[i] = data->qpos[qpos_[static_cast<std::size_t>(arm_ + i)]] + spec.closing / spec.kp;
    }
  }
  return targets;
}

Grip JointMap::grip(const mjModel* model, const mjData* data, int object_geom) const {
  std::vector<bool> touching(thumb_.size(), false);
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.exclude != 0 || (contact.geom1 != object_geom && contact.geom2 != object_geom)) continue;
    const int other = contact.geom1 == object_geom ? contact.geom2 : contact.geom1;
    const int finger = finger_of_body_[static_cast<std::size_t>(model->geom_bodyid[other])];
    if (finger >= 0) touching[static_cast<std::size_t>(finger)] = true;
  }
  Grip grip;
  for (std::size_t t = 0; t < touching.size(); ++t) {
    if (!touching[t]) continue;
    if (thumb_[t]) {
      grip.thumb = true;
    } else {
      ++grip.fingers;
    }
  }
  return grip;
}

bool JointMap::touches_robot(const mjModel* model, const mjData* data, int geom) const {
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.exclude != 0 || (contact.geom1 != geom && contact.geom2 != geom)) continue;
    const int other = contact.geom1 == geom ? contact.geom2 : contact.geom1;
    if (robot_body_[static_cast<std::size_t>(model->geom_bodyid[other])]) return true;
  }
  return false;
}

namespace {

/// Turns the closing joints of each finger by `step` (positive closes) while `go_on(smallest distance of the finger to
/// the object)`.
template <class GoOn>
Eigen::VectorXd turn_fingers(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                             double step, double most, GoOn go_on) {
  const auto finger = finger_of_body(robot);
  Eigen::VectorXd turned = q;
  robot::Kinematics kinematics;
  for (int t = 0; t < static_cast<int>(robot.fingertips().size()); ++t) {
    const auto gap = [&] {
      double smallest = std::numeric_limits<double>::infinity();
      robot.forward(turned, kinematics);
      for (const auto& link : robot.link_shapes()) {
        if (finger[static_cast<std::size_t>(link.body)] != t) continue;
        smallest = std::min(smallest, robot::distance(link.shape, robot.pose(kinematics, link), object, X_WO).distance);
      }
      return smallest;
    };
    for (double moved = 0; moved + std::abs(step) <= most + 1e-9 && go_on(gap()); moved += std::abs(step)) {
      for (const auto& joint : robot.chain()) {
        const int hand_joint = joint.index - robot.arm_joints();
        if (hand_joint < 0 || finger[static_cast<std::size_t>(joint.body)] != t) continue;
        const double closing = robot.file().hand[static_cast<std::size_t>(hand_joint)].closing;
        if (closing == 0) continue;
        turned[joint.index] = std::clamp(turned[joint.index] + std::copysign(step, step * closing),
                                         robot.lower()[joint.index], robot.upper()[joint.index]);
      }
    }
  }
  return turned;
}

}  // namespace

Eigen::VectorXd back_off(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                         double most) {
  return turn_fingers(robot, q, object, X_WO, -0.02, most, [](double gap) { return gap < 0; });
}

Eigen::VectorXd close_onto(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                           double most) {
  return turn_fingers(robot, q, object, X_WO, 0.01, most, [](double gap) { return gap > 0; });
}

}  // namespace primo::physics

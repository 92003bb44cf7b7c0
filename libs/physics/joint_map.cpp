#include "physics/joint_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "robot/distance.h"

namespace primo::physics {

namespace {

/// Gives the links that hang on a finger by loops to it: the other side of the loop, up to what is shared.
void add_links_in_loops(const robot::Robot& robot, const std::vector<int>& users, std::vector<int>& finger) {
  constexpr int kShared = -2;
  const auto& bodies = robot.bodies();
  for (bool more = true; more;) {
    more = false;
    for (const auto& [one, two] : robot.loops()) {
      for (const auto& [from, to] : {std::pair(one, two), std::pair(two, one)}) {
        const int owner = finger[static_cast<std::size_t>(from)];
        if (owner == -1) continue;
        for (int b = to; b > 0 && bodies[static_cast<std::size_t>(b)].hand && users[static_cast<std::size_t>(b)] == 0;
             b = bodies[static_cast<std::size_t>(b)].parent) {
          int& mine = finger[static_cast<std::size_t>(b)];
          const int now = mine == -1 || mine == owner ? owner : kShared;
          more = more || now != mine;
          mine = now;
        }
      }
    }
  }
  std::replace(finger.begin(), finger.end(), kShared, -1);
}

}  // namespace

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
  add_links_in_loops(robot, users, finger);
  return finger;
}

std::string Grip::complaint() const {
  if (has_thumb) return thumb ? "only the thumb touches the object" : "the thumb does not touch the object";
  if (parts() == 1) return "only fingertip " + only + " touches the object";
  return "the fingers that touch the object push from the same side";
}

JointMap::JointMap(const robot::Robot& robot, const mjModel* model)
    : qpos_(static_cast<std::size_t>(robot.joints()), -1),
      dof_(qpos_),
      finger_of_body_(static_cast<std::size_t>(model->nbody), -1),
      robot_body_(static_cast<std::size_t>(model->nbody), false),
      arm_(robot.arm_joints()) {
  for (const auto& joint : robot.chain()) {
    const int id = mj_name2id(model, mjOBJ_JOINT, joint.name.c_str());
    if (id >= 0) slots_.push_back({joint, model->jnt_qposadr[id], model->jnt_dofadr[id]});
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
  for (const auto& tip : robot.fingertips()) {
    thumb_.push_back(tip.thumb);
    tip_names_.push_back(tip.name);
    has_thumb_ = has_thumb_ || tip.thumb;
  }
}

void JointMap::set(mjData* data, const Eigen::VectorXd& q) const {
  for (const auto& slot : slots_) {
    data->qpos[slot.qpos] = slot.joint.value(q[slot.joint.index]);
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
  std::vector<Eigen::Vector3d> push(thumb_.size(), Eigen::Vector3d::Zero());  // by fingertip: the sum of its contacts'
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.exclude != 0 || (contact.geom1 != object_geom && contact.geom2 != object_geom)) continue;
    const bool object_first = contact.geom1 == object_geom;
    const int other = object_first ? contact.geom2 : contact.geom1;
    const int finger = finger_of_body_[static_cast<std::size_t>(model->geom_bodyid[other])];
    if (finger < 0) continue;
    touching[static_cast<std::size_t>(finger)] = true;
    // MuJoCo's contact normal points from the first geom to the second.
    push[static_cast<std::size_t>(finger)] += (object_first ? -1.0 : 1.0) * Eigen::Vector3d(contact.frame);
  }
  Grip grip;
  grip.has_thumb = has_thumb_;
  for (std::size_t t = 0; t < touching.size(); ++t) {
    if (!touching[t]) continue;
    if (thumb_[t]) {
      grip.thumb = true;
    } else {
      ++grip.fingers;
    }
    grip.only = tip_names_[t];
    for (std::size_t u = 0; u < t; ++u) grip.from_sides = grip.from_sides || (touching[u] && push[t].dot(push[u]) < 0);
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

/// Fingers that move together because they share closing joints.
struct FingerGroup {
  std::vector<int> fingers;
  std::vector<int> joints;  ///< of q: the listed joints that close them
};

std::vector<FingerGroup> finger_groups(const robot::Robot& robot, const std::vector<int>& finger) {
  std::vector<FingerGroup> groups;
  for (int t = 0; t < static_cast<int>(robot.fingertips().size()); ++t) {
    FingerGroup group{{t}, {}};
    for (const auto& joint : robot.chain()) {
      const int hand_joint = joint.index - robot.arm_joints();
      if (hand_joint < 0 || finger[static_cast<std::size_t>(joint.body)] != t) continue;
      if (robot.file().hand[static_cast<std::size_t>(hand_joint)].closing == 0) continue;
      // A coupled joint is driven by the same q.
      if (std::find(group.joints.begin(), group.joints.end(), joint.index) == group.joints.end())
        group.joints.push_back(joint.index);
    }
    const auto shares = [&](const FingerGroup& other) {
      return std::find_first_of(other.joints.begin(), other.joints.end(), group.joints.begin(), group.joints.end()) !=
             other.joints.end();
    };
    for (auto other = std::find_if(groups.begin(), groups.end(), shares); other != groups.end();
         other = std::find_if(groups.begin(), groups.end(), shares)) {
      group.fingers.insert(group.fingers.begin(), other->fingers.begin(), other->fingers.end());
      for (const int joint : other->joints) {
        if (std::find(group.joints.begin(), group.joints.end(), joint) == group.joints.end())
          group.joints.push_back(joint);
      }
      groups.erase(other);
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

/// Moves the closing joints of each finger by `step` (rad; positive closes) while `go_on(smallest distance of the
/// finger to the object)`.
template <class GoOn>
Eigen::VectorXd turn_fingers(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                             double step, double most, GoOn go_on) {
  const auto finger = finger_of_body(robot);
  Eigen::VectorXd turned = q;
  robot::Kinematics kinematics;
  for (const auto& group : finger_groups(robot, finger)) {
    const auto gap = [&] {
      double smallest = std::numeric_limits<double>::infinity();
      robot.forward(turned, kinematics);
      for (const auto& link : robot.link_shapes()) {
        const int t = finger[static_cast<std::size_t>(link.body)];
        if (std::find(group.fingers.begin(), group.fingers.end(), t) == group.fingers.end()) continue;
        smallest = std::min(smallest, robot::distance(link.shape, robot.pose(kinematics, link), object, X_WO).distance);
      }
      return smallest;
    };
    for (double moved = 0; moved + std::abs(step) <= most + 1e-9 && go_on(gap()); moved += std::abs(step)) {
      for (const int joint : group.joints) {
        const double closing = robot.file().hand[static_cast<std::size_t>(joint - robot.arm_joints())].closing;
        const double travel = robot.slides(joint) ? step * kFingerLength : step;
        turned[joint] = std::clamp(turned[joint] + std::copysign(travel, travel * closing), robot.lower()[joint],
                                   robot.upper()[joint]);
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

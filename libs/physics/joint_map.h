// Where a robot's joints and fingers are in a MuJoCo model of it, whole or hand only, and the torques that drive the
// hand.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/model.h"
#include "robot/robot.h"

namespace primo::physics {

/// Which parts of the hand touch an object.
struct Grip {
  bool has_thumb = true;  ///< whether the robot file names one
  bool thumb = false;
  int fingers = 0;          ///< touching, other than the thumb
  bool from_sides = false;  ///< two fingers push in directions more than a right angle apart
  std::string only = {};    ///< the one fingertip that touches, when it is one
  int parts() const { return static_cast<int>(thumb) + fingers; }
  /// Thumb against at least one finger; in a hand without a thumb, two fingers from opposite sides.
  bool opposed() const { return has_thumb ? thumb && fingers > 0 : from_sides; }
  /// Why not, in words. @pre some part touches, and not opposed().
  std::string complaint() const;
};

class JointMap {
 public:
  JointMap() = default;
  /// Joints and bodies that `model` does not have (the arm's, in a model of the hand) are left out.
  JointMap(const robot::Robot& robot, const mjModel* model);

  /// Puts all joints present to q, coupled ones too, at rest.
  void set(mjData* data, const Eigen::VectorXd& q) const;
  /// Listed joints present, in q's order; others keep the value of `q`.
  void get(const mjData* data, Eigen::VectorXd& q, Eigen::VectorXd& velocity) const;
  /// The dof of listed joint i, or −1.
  int dof(int i) const { return dof_[static_cast<std::size_t>(i)]; }

  /// Torque of hand joint i's servo towards `target`, limited, written into qfrc_applied.
  void servo(const robot::Robot& robot, mjData* data, int hand_joint, double target) const;
  /// The closing torque itself; joints without one are held at `held[i]`.
  void close(const robot::Robot& robot, mjData* data, const Eigen::VectorXd& held) const;
  /// Servo targets that keep pressing with the closing torque where the fingers are now.
  Eigen::VectorXd frozen_targets(const robot::Robot& robot, const mjData* data, const Eigen::VectorXd& held) const;

  Grip grip(const mjModel* model, const mjData* data, int object_geom) const;
  /// What holds an object, in words: "thumb and fingers", or "the fingers" of a hand without a thumb.
  const char* holders() const { return has_thumb_ ? "thumb and fingers" : "the fingers"; }
  /// Whether any geom of the robot touches `geom`.
  bool touches_robot(const mjModel* model, const mjData* data, int geom) const;

 private:
  struct Slot {
    robot::ChainJoint joint;
    int qpos = 0, dof = 0;
  };
  std::vector<Slot> slots_;
  std::vector<int> qpos_, dof_;      // by listed joint; −1: not in the model
  std::vector<int> finger_of_body_;  // by model body: fingertip index, or −1
  std::vector<bool> robot_body_;
  std::vector<bool> thumb_;  // by fingertip
  std::vector<std::string> tip_names_;
  bool has_thumb_ = false;
  int arm_ = 0;
};

/// For each body of the robot, the fingertip whose own chain it is part of (not shared with another fingertip), or −1.
/// Links that loops tie to one finger's chain are part of it, too.
std::vector<int> finger_of_body(const robot::Robot& robot);

/// A slide joint of a finger moves as far as the tip of a hinged finger of this length would, m for each rad.
inline constexpr double kFingerLength = 0.1;

/// `q` with fingers that overlap the object opened, all closing joints of a finger by the same travel, against their
/// closing direction, until the finger is clear or has moved `most` rad (slides: `most` · kFingerLength, m). Fingers
/// that are clear stay, but for those that share a joint with one that is not.
Eigen::VectorXd back_off(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                         double most);

/// `q` with every finger closed, its closing joints by the same travel, until it (or one that shares a joint with it)
/// touches the object or has moved `most` rad (slides: `most` · kFingerLength, m): how a closed hand looks without
/// physics.
Eigen::VectorXd close_onto(const robot::Robot& robot, const Eigen::VectorXd& q, const Shape& object, const Pose& X_WO,
                           double most = 0.7);

}  // namespace primo::physics

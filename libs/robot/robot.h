// A robot read from its robot file and MJCF: joints, limits, hand, grasp frame and the kinematic chain.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/pose.h"
#include "core/result.h"
#include "robot/shape.h"

namespace primo::robot {

/// A frame fixed to a body of the MJCF model: X_BF.
struct FrameSpec {
  std::string body;
  Eigen::Vector3d position{0, 0, 0};  ///< p_BF, m
  Eigen::Vector3d rpy{0, 0, 0};       ///< rad
  template <class V>
  void visit(V&& v) {
    v("body", body, {.help = "body of the MJCF model", .required = true});
    v("position", position, {.unit = "m"});
    v("rpy", rpy, {.unit = "rad"});
  }
};

/// A fingertip: the centre of its pad and the pad's outward normal (towards a grasped object).
struct FingertipSpec {
  std::string name;
  FrameSpec frame;                    ///< origin: the tip's centre; z: the pad's outward normal
  bool thumb = false;                 ///< opposes the others
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("frame", frame, {.help = "origin: the tip's centre; z: the pad's outward normal", .required = true});
    v("thumb", thumb, {.help = "opposes the others"});
  }
};

struct ArmJointSpec {
  std::string joint;
  double control_weight = 1.0;  ///< W
  double home = 0.0;            ///< rad
  double max_speed = 2.0;       ///< rad/s
  double kp = 0, kd = 0;        ///< tracking gains in execution, N·m/rad and N·m·s/rad
  double max_torque = 0;        ///< N·m
  template <class V>
  void visit(V&& v) {
    v("joint", joint, {.required = true});
    v("control_weight", control_weight, {.help = "W", .min = 1e-9});
    v("home", home, {.unit = "rad"});
    v("max_speed", max_speed, {.unit = "rad/s", .min = 0});
    v("kp", kp, {.unit = "N·m/rad", .min = 0});
    v("kd", kd, {.unit = "N·m·s/rad", .min = 0});
    v("max_torque", max_torque, {.unit = "N·m", .min = 0});
  }
};

struct HandJointSpec {
  std::string joint;
  double control_weight = 0.1;
  double home = 0.0;            ///< rad, fingers open
  double closing = 0.0;         ///< N·m and direction: torque that closes the hand on an object; 0: held
  double kp = 0, kd = 0;        ///< position servo, N·m/rad and N·m·s/rad
  double max_torque = 0;        ///< N·m
  template <class V>
  void visit(V&& v) {
    v("joint", joint, {.required = true});
    v("control_weight", control_weight, {.help = "W", .min = 1e-9});
    v("home", home, {.help = "fingers open", .unit = "rad"});
    v("closing", closing, {.help = "signed torque that closes the hand; 0: the joint is held", .unit = "N·m"});
    v("kp", kp, {.unit = "N·m/rad", .min = 0});
    v("kd", kd, {.unit = "N·m·s/rad", .min = 0});
    v("max_torque", max_torque, {.unit = "N·m", .min = 0});
  }
};

/// A robot file (YAML). Joint order of every q in primo: arm joints, then hand joints. Joints that an MJCF equality couples to a listed
/// one follow it and are not listed.
struct RobotFile {
  std::string name;
  std::string mjcf;                        ///< relative to the robot file
  std::vector<ArmJointSpec> arm;
  std::vector<HandJointSpec> hand;
  FrameSpec grasp_frame;                   ///< origin: where the object's centre should be; z: approach; x: opposition, thumb to fingers
  std::vector<FingertipSpec> fingertips;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("mjcf", mjcf, {.help = "MJCF model, relative to this file", .required = true});
    v("arm", arm, {.help = "arm joints from the base outwards", .required = true});
    v("hand", hand, {.help = "independent hand joints", .required = true});
    v("grasp_frame", grasp_frame, {.help = "origin: where the object's centre should be; z: approach; x: opposition, thumb to fingers", .required = true});
    v("fingertips", fingertips, {.required = true});
  }
};

}  // namespace primo::robot

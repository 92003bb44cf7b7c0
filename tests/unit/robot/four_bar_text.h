// A gripper with closed loops for tests, on the arm of the shipped second robot: two fingers, each carried parallel by
// a crank and a rocker as a parallelogram, which <connect> closes. An actuator on a tendon splits its torque between
// both cranks, as such grippers' models have it.
//
//   y and x of the hand's frame:       θ is the crank's angle from the approach (z), positive outwards; from the pivot
//   at z ↑   finger      finger           x = 20 mm the finger's inner face is at x = 20 mm + 70 mm sin θ, and its foot
//   at
//        /‾‾/        \‾‾\              z = 70 mm + 70 mm cos θ.
//       crank,rocker  crank,rocker
#pragma once

#include <string>

#include "core/files.h"
#include "robot_text.h"

namespace primo::robot {

inline constexpr double kCrank = 0.07;       ///< m, length of crank and rocker
inline constexpr double kPivot = 0.02;       ///< m, x of the crank's pivot in the gripper's frame
inline constexpr double kRockerAway = 0.03;  ///< m from the crank to the rocker, on palm and finger

/// What the tests change of it.
struct FourBar {
  double rocker_away = kRockerAway;  ///< m, where the rocker stands on the palm
  std::string range = "-0.3 0.85";   ///< of the crank
  std::string connect = R"(<connect body1="SIDE_rocker" body2="SIDE_finger" anchor="0 0 0.07" solref="0.005 1"/>)";
  std::string coupling = R"(<joint joint1="right" joint2="left" solref="0.005 1"/>)";
  std::string more_equalities = "";
};

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

/// Writes robot.yaml and robot.xml.
inline void write_four_bar(const RobotFolder& folder, const FourBar& about = {}) {
  const std::string rocker = std::to_string(kPivot + about.rocker_away);
  const auto side = [&](const std::string& name, const std::string& turn) {
    return replaced(R"(<body name="SIDE" pos="0 0 0.07" euler="0 0 )" + turn + R"(" childclass="four_bar">
        <body name="SIDE_crank" pos="0.02 0 0"><joint name="SIDE" range=")" +
                        about.range + R"(" damping="0.1" armature="0.005"/>
          <geom type="capsule" fromto="0 0 0 0 0 0.07" size="0.006" mass="0.03"/>
          <body name="SIDE_finger" pos="0 0 0.07"><joint name="SIDE_knuckle" range="-1.5 1.5"/>
            <geom type="box" pos="0.016 0 0.046" size="0.008 0.017 0.046" mass="0.06"/>
            <geom type="capsule" fromto="0.008 -0.012 0.058 0.008 -0.012 0.084" size="0.008" mass="0.01"/>
            <geom type="capsule" fromto="0.008 0.012 0.058 0.008 0.012 0.084" size="0.008" mass="0.01"/>
            <site name="SIDE_tip" pos="0 0 0.071" euler="0 -1.5707963267948966 0"/></body></body>
        <body name="SIDE_rocker" pos=")" +
                        rocker + R"( 0 0"><joint name="SIDE_rocker" range="-1.5 1.5"/>
          <geom type="capsule" fromto="0 0 0 0 0 0.07" size="0.006" mass="0.03"/></body></body>
)",
                    "SIDE", name);
  };
  const std::string shipped = std::string(PRIMO_SOURCE_DIR) + "/configs/robots/column7_pg130";
  std::string model = read_file(shipped + ".xml").value();
  const auto hand = model.find("<site name=\"grasp\""), last = model.find("<body name=\"right_finger\"");
  model.replace(hand, model.find("</body>", last) + 7 - hand,
                "<site name=\"grasp\" pos=\"0 0 0.2088\"/>\n" + side("left", "0") + side("right", "3.141592653589793"));
  model.insert(model.find("<default class=\"arm\">"), R"(<default class="four_bar">
    <joint type="hinge" axis="0 1 0" damping="0.01" armature="0.0005"/>
    <geom condim="4" friction="0.9 0.01 0.0005" solref="0.01 1" solimp="0.95 0.99 0.001"/></default>)");
  const auto rest = model.find("<contact>");
  model.replace(
      rest, model.find("</mujoco>") - rest,
      R"(<tendon><fixed name="split"><joint joint="left" coef="0.5"/><joint joint="right" coef="0.5"/></fixed></tendon>
  <equality>)" +
          replaced(about.connect, "SIDE", "left") + replaced(about.connect, "SIDE", "right") + about.coupling +
          about.more_equalities + R"(</equality>
  <actuator><general name="fingers" tendon="split" biastype="affine" gainprm="60" biasprm="0 -60 -1"/></actuator>)");
  folder.put("robot.xml", model);
  std::string robot = read_file(shipped + ".yaml").value();
  robot = replaced(robot, "column7_pg130", "four_bar");
  robot = replaced(robot, "four_bar.xml", "robot.xml");
  const auto joint = robot.find("  - {joint: left,");
  robot.replace(joint, robot.find('\n', joint) - joint,
                "  - {joint: left, control_weight: 0.1, home: 0.7, closing: -4, kp: 60, kd: 0.5, max_torque: 6}");
  folder.put("robot.yaml", robot);
}

}  // namespace primo::robot

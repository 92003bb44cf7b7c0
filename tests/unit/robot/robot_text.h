// Robots written by the tests: a folder with a robot file, its model and what that includes, gone with the object.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "robot/robot.h"

namespace primo::robot {

class RobotFolder {
 public:
  RobotFolder() {
    static std::atomic<int> count = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("primo_robot_text_" + std::to_string(getpid()) + "_" + std::to_string(++count));
    std::filesystem::create_directories(folder_);
  }
  ~RobotFolder() { std::filesystem::remove_all(folder_); }
  RobotFolder(const RobotFolder&) = delete;
  RobotFolder& operator=(const RobotFolder&) = delete;

  void put(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  Result<Robot> load() const { return Robot::load(folder_ / "robot.yaml"); }
  std::string error() const {
    auto robot = load();
    return robot.ok() ? "no error" : robot.error().message;
  }

 private:
  std::filesystem::path folder_;
};

/// What a generated robot is like. All hands are round: fingertips on a circle about the approach axis, pads inwards.
struct GeneratedRobot {
  int arm = 7;  ///< hinges about y and z in turns, 1.2 m long in all
  int fingers = 3;
  bool slides = false;   ///< fingers slide towards the axis instead of turning
  bool coupled = false;  ///< one joint drives all fingers, by joint equalities
  bool thumb = false;    ///< the first fingertip is the thumb
  bool rail = false;     ///< the first arm joint slides along x, at most 0.5 m/s
};

/// Writes robot.yaml and robot.xml of such a robot.
inline void write_robot(const RobotFolder& folder, const GeneratedRobot& about) {
  const double length = 1.2 / about.arm, circle = about.slides ? 0.0 : 0.04;
  const auto text = [](double value) { return std::to_string(value); };
  std::string bodies, close, arm, hand, tips, equalities;
  for (int i = 0; i < about.arm; ++i) {
    const std::string n = std::to_string(i);
    const bool rail = about.rail && i == 0;
    bodies += "<body name=\"b" + n + "\" pos=\"0 0 " + text(i ? length : 0.0) + "\"><joint name=\"j" + n +
              "\" axis=\"" +
              (rail    ? "1 0 0\" type=\"slide"
               : i % 2 ? "0 0 1"
                       : "0 1 0") +
              "\" range=\"-1.5 1.5\"/><geom type=\"capsule\" fromto=\"0 0 0 0 0 " + text(length) +
              "\" size=\"0.015\" mass=\"0.2\"/>\n";
    close += "</body>";
    arm += "  - {joint: j" + n + ", control_weight: 0.2, home: " + (i % 2 ? "0.1" : "0.2") +
           (rail ? ", max_speed: 0.5" : "") + ", kp: 500, kd: 20, max_torque: 200}\n";
  }
  bodies +=
      "<body name=\"palm\" pos=\"0 0 " + text(length) + "\"><geom type=\"box\" size=\"0.05 0.05 0.01\" mass=\"0.3\"/>";
  for (int f = 0; f < about.fingers; ++f) {
    const std::string n = std::to_string(f);
    const double turn = 2 * M_PI * f / about.fingers;
    // Each finger stands at +x of its own frame; its pad faces −x, towards the axis.
    bodies += "<body name=\"finger" + n + "\" pos=\"" + text(circle * std::cos(turn)) + " " +
              text(circle * std::sin(turn)) + " 0.01\" euler=\"0 0 " + text(turn) + "\"><joint name=\"f" + n + "\" " +
              (about.slides ? "type=\"slide\" axis=\"1 0 0\" range=\"0 0.08\"" : "axis=\"0 -1 0\" range=\"-1.2 1.2\"") +
              " damping=\"" + (about.slides ? "5" : "0.1") + "\" armature=\"0.01\"/><geom type=\"capsule\" fromto=\"" +
              (about.slides ? "0.01 0 0.01 0.01 0 0.1" : "0 0 0.01 0 0 0.1") +
              "\" size=\"0.01\" mass=\"0.1\" condim=\"4\" friction=\"0.9 0.01 0.0005\"/></body>\n";
    if (f == 0 || !about.coupled) {
      hand += "  - {joint: f" + n + ", home: " + (about.slides ? "0.07" : "-0.3") + ", closing: " +
              (about.slides ? "-30, kp: 2000, kd: 20, max_torque: 60" : "1.0, kp: 20, kd: 0.3, max_torque: 2") + "}\n";
    } else {
      equalities += "<joint joint1=\"f" + n + "\" joint2=\"f0\" polycoef=\"0 1 0 0 0\" solref=\"0.005 1\"/>";
    }
    tips += "  - {name: tip" + n + ", thumb: " + (about.thumb && f == 0 ? "true" : "false") + ", frame: {body: finger" +
            n + ", position: [" + (about.slides ? "0.0" : "-0.01") + ", 0, 0.09], rpy: [0, -1.5707963267948966, 0]}}\n";
  }
  folder.put("robot.xml", "<mujoco><compiler angle=\"radian\" autolimits=\"true\"/><worldbody>\n" + bodies + "</body>" +
                              close + "</worldbody><equality>" + equalities + "</equality></mujoco>\n");
  folder.put("robot.yaml", "name: generated\nmjcf: robot.xml\narm:\n" + arm + "hand:\n" + hand +
                               "grasp_frame: {body: palm, position: [0, 0, 0.09]}\nfingertips:\n" + tips);
}

inline Robot generated_robot(const GeneratedRobot& about) {
  const RobotFolder folder;
  write_robot(folder, about);
  auto robot = folder.load();
  PRIMO_CHECK(robot.ok(), robot.error().message);
  return std::move(robot).value();
}

}  // namespace primo::robot

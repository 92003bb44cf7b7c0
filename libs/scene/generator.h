// Scenarios from random numbers: displaced copies of a scenario, and scenes with a target among obstacles.
// Streams are keyed by (seed, index), so that scene 17 of a seed is the same whichever others are drawn.
#pragma once

#include <cstdint>

#include "core/result.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::scene {

/// A displaced scenario and what was refused before it.
struct Displaced {
  Scenario scenario;
  int rejected_touching = 0;  ///< draws in which two objects touched
  int rejected_falling = 0;   ///< draws in which an object's centre was beyond the table's edge
  int rejected_in_robot = 0;  ///< draws in which an object lay in the robot at its start
  int rejected() const { return rejected_touching + rejected_falling + rejected_in_robot; }
};

/// Moves every object that the hand does not hold by uniform noise in ±d along x and y, each on its own; draws in which
/// objects touch each other or fall off the table are rejected and drawn anew (paper, V.A). d in m, 0 … 0.5. Camera
/// noise gets a seed of its own. Errors (config): no valid draw in `max_tries`, with the counts of both reasons; an
/// invalid base.
Result<Displaced> displace(const Scenario& base, double d, std::uint64_t seed, std::uint64_t index,
                           int max_tries = 2000);

/// As above; draws in which an object that is not held overlaps the robot at robot_start are rejected, too. Where none
/// does, the scenario is the same to the byte.
Result<Displaced> displace(const robot::Robot& robot, const Scenario& base, double d, std::uint64_t seed,
                           std::uint64_t index, int max_tries = 2000);

/// How random scenes look: a target cylinder "c1" and obstacles around it, within the arm's reach.
struct RandomSceneSettings {
  Eigen::Vector2d lower{0.72, -0.14};  ///< m in W, of the target's centre
  Eigen::Vector2d upper{0.90, 0.14};   ///< m in W
  int min_obstacles = 1;
  int max_obstacles = 3;
  double min_distance = 0.12;  ///< m, centre of an obstacle to centre of the target
  double max_distance = 0.16;  ///< m
  double radius = 0.0375;      ///< m, of the cylinders
  double boxes = 0.3;          ///< share of obstacles that are boxes; the others are cylinders like the target
  double min_gap = 0.01;       ///< m between any two objects
  double depth_noise = 0.0;    ///< m, of the cameras
  template <class V>
  void visit(V&& v) {
    v("lower", lower, {.help = "of the target's centre", .unit = "m", .min = -5, .max = 5});
    v("upper", upper, {.help = "of the target's centre", .unit = "m", .min = -5, .max = 5});
    v("min_obstacles", min_obstacles, {.min = 0, .max = 12});
    v("max_obstacles", max_obstacles, {.min = 0, .max = 12});
    v("min_distance", min_distance, {.help = "obstacle to target, centres", .unit = "m", .min = 0, .max = 1});
    v("max_distance", max_distance, {.help = "obstacle to target, centres", .unit = "m", .min = 0, .max = 1});
    v("radius", radius, {.help = "of the cylinders", .unit = "m", .min = 0.005, .max = 0.1});
    v("boxes", boxes, {.help = "share of obstacles that are boxes", .min = 0, .max = 1});
    v("min_gap", min_gap, {.help = "between any two objects", .unit = "m", .min = 0.0005, .max = 0.5});
    v("depth_noise", depth_noise, {.help = "of the cameras", .unit = "m", .min = 0, .max = 0.1});
  }
};

/// A scene of the published cylinders (height 0.108 m) and boxes, with the action [grasp, c1]. With no
/// obstacles at all, min_obstacles = max_obstacles = 0. Errors (config): bounds the wrong way round, or no room after
/// bounded tries.
Result<Scenario> random_scenario(const RandomSceneSettings& settings, std::uint64_t seed, std::uint64_t index);

}  // namespace primo::scene

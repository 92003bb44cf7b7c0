// What the judge is asked and what it answers.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "robot/shape.h"
#include "scene/scenario.h"
#include "symbols/literal.h"

namespace primo::physics {

enum class Mode { final_pose, execute };

/// When a placed object counts as on its support.
enum class PlaceCriterion {
  full,  ///< after the release: height, horizontal offset, tilt, rest, contact with the support, none with the hand
  paper  ///< the vertical displacement of the centres at the end of the motion, alone
};

/// How far a grasp or a place got: the stage its graded score comes from.
enum class Outcome {
  bad_plan,             ///< the trajectory cannot be judged
  no_contact,           ///< the closed fingers miss the object
  initial_penetration,  ///< the hand is inside the object by more than the limit
  not_opposed,          ///< contact, but not thumb against finger
  fell_at_release,
  fell_in_jiggle,
  contact_lost,  ///< held, but thumb and finger do not both touch at the end
  held,
  unstable,  ///< the simulation diverged
  placed,
  not_released,  ///< the hand still touches the object that it has let go
  support_fell,  ///< the support fell over
  not_on,        ///< the object is elsewhere, or leans or moves on its support
};
}  // namespace primo::physics

template <>
struct primo::config::EnumNames<primo::physics::Mode> {
  static constexpr std::array<std::string_view, 2> names = {"final_pose", "execute"};
};
template <>
struct primo::config::EnumNames<primo::physics::PlaceCriterion> {
  static constexpr std::array<std::string_view, 2> names = {"full", "paper"};
};
template <>
struct primo::config::EnumNames<primo::physics::Outcome> {
  static constexpr std::array<std::string_view, 13> names = {
      "bad_plan",        "no_contact",     "initial_penetration", "not_opposed",
      "fell_at_release", "fell_in_jiggle", "contact_lost",        "held",
      "unstable",        "placed",         "not_released",        "support_fell",
      "not_on"};
};

namespace primo::physics {

/// Settings of the judge: timing, jiggle, margins and what counts as placed. Defaults are the measured ones.
struct JudgeSettings {
  double timestep = 0.002;            // s
  double close_seconds = 0.5;         // s, fingers closing with the object pinned
  double jiggle_seconds = 1.0;        // s
  double jiggle_frequency = 3.0;      // Hz, band limit
  double jiggle_translation = 0.012;  // m rms
  double jiggle_rotation = 0.1;       // rad rms
  double max_displacement = 0.04;     // m in the palm frame
  double max_penetration = 0.006;     // m at the final pose
  double clearance_margin = 0.0;      // m, hand and arm to obstacles and table along the path
  double target_margin = -0.006;      // m, hand to target along the path
  double max_joint_speed = 2.0;       // rad/s, arm
  double limit_margin = 0.0;          // rad
  PlaceCriterion place_criterion = PlaceCriterion::full;
  double place_height = 0.01;  // m, of the vertical displacement from one on top of the other
  double place_offset = 0.03;  // m, between the centres: beyond, cylinders of the paper's size are about to tip
  double place_tilt = 0.1;     // rad
  double place_speed = 0.02;   // m/s, of any point of a body at rest
  // A held final pose is shaken again, survival_seeds times at each amplitude (times the jiggle's rms). Off: it costs a
  // trial each, and the verdict does not depend on it.
  std::vector<double> survival_amplitudes = {0.5, 1.0, 1.5};
  int survival_seeds = 0;
  template <class V>
  void visit(V&& v) {
    v("timestep", timestep, {.help = "of the simulation", .unit = "s", .min = 1e-4, .max = 0.01});
    v("close_seconds", close_seconds,
      {.help = "fingers closing with the object pinned", .unit = "s", .min = 0.05, .max = 5});
    v("jiggle_seconds", jiggle_seconds, {.help = "how long the hand is shaken", .unit = "s", .min = 0, .max = 30});
    v("jiggle_frequency", jiggle_frequency, {.help = "band limit", .unit = "Hz", .min = 0.1, .max = 20});
    v("jiggle_translation", jiggle_translation, {.help = "rms", .unit = "m", .min = 0, .max = 0.2});
    v("jiggle_rotation", jiggle_rotation, {.help = "rms", .unit = "rad", .min = 0, .max = 1});
    v("max_displacement", max_displacement,
      {.help = "of the object in the palm frame", .unit = "m", .min = 0.001, .max = 0.5});
    v("max_penetration", max_penetration,
      {.help = "hand into object at the final pose", .unit = "m", .min = 0, .max = 0.05});
    v("clearance_margin", clearance_margin,
      {.help = "robot to obstacles and table along the path", .unit = "m", .min = -0.1, .max = 0.2});
    v("target_margin", target_margin, {.help = "hand to target along the path", .unit = "m", .min = -0.1, .max = 0.1});
    v("max_joint_speed", max_joint_speed, {.help = "arm joints", .unit = "rad/s", .min = 0.1, .max = 50});
    v("limit_margin", limit_margin, {.help = "to the joint limits", .unit = "rad", .min = -1, .max = 1});
    v("place_criterion", place_criterion,
      {.help = "full: height, offset, tilt, rest and contacts after the release; paper: the height at the end alone"});
    v("place_height", place_height,
      {.help = "of a placed object's centre, from one on top of the other", .unit = "m", .min = 0.001, .max = 0.1});
    v("place_offset", place_offset, {.help = "of a placed object, horizontal", .unit = "m", .min = 0.001, .max = 0.5});
    v("place_tilt", place_tilt, {.help = "of a placed object's axis", .unit = "rad", .min = 0.001, .max = 1.5});
    v("place_speed", place_speed,
      {.help = "below which a placed object is at rest", .unit = "m/s", .min = 1e-4, .max = 1});
    v("survival_amplitudes", survival_amplitudes,
      {.help = "of the survival table, times the jiggle's rms", .min = 0, .max = 10});
    v("survival_seeds", survival_seeds,
      {.help = "jiggles at each amplitude of the survival table; 0: no table", .min = 0, .max = 1000});
  }
};

/// One of the paper's criteria: its value, the margin it is held against, and whether it is met.
struct Criterion {
  std::string name;  ///< clearance, target_clearance, limit_margin, joint_speed, path_length, iterations
  double value = 0;
  double margin = 0;
  bool met = false;
};

/// How a grasp fares in jiggles of one amplitude, with seeds of their own: a signal finer than one jiggle's verdict.
struct Survival {
  double amplitude = 1;     ///< times the settings' rms
  int seeds = 0;            ///< jiggles
  int held = 0;             ///< of them
  double survival = 0;      ///< mean fraction of the jiggle survived
  double displacement = 0;  ///< m, mean of the largest in the palm frame
};

/// Two bodies that touched while a motion was executed. Bodies are the robot's links, objects, the table, the floor.
struct Contact {
  std::string first, second;  ///< of the scene last, of the robot first
  double begin = 0, end = 0;  ///< s since the start: the first and the last time they touched
  double peak_force = 0;      ///< N, largest sum of their normal forces
};

struct JudgeRequest {
  scene::Scenario scenario;        ///< the true scene
  Eigen::MatrixXd q;               ///< rad, (T+1) × n, the robot file's joint order
  double dt = 0;                   ///< s
  int planner_iterations = 0;      ///< accepted + rejected
  std::vector<Eigen::MatrixXd> K;  ///< feedback gains for Mode::execute; empty: plain tracking
  std::uint64_t seed = 0;          ///< of the jiggle
  Mode mode = Mode::final_pose;
  JudgeSettings settings;
};

struct Verdict {
  bool success = false;             ///< strict: final-pose (or executed) success and a clean path
  bool final_pose_success = false;  ///< the paper's verdict alone (in Mode::execute: the executed verdict alone)
  bool path_clean = false;          ///< clearance, target clearance, limits and speeds are all met
  Outcome outcome = Outcome::bad_plan;
  std::string reason;               ///< one sentence: what decided
  double score = 0;                 ///< s of the graded fitness, in [0, 1]
  double displacement = 0;          ///< m, of the object in the palm frame; of a place: before it is let go
  double survival = 0;              ///< fraction of the jiggle survived
  double position_error = 0;        ///< m, at T: grasp centre to object centre, or held object to its place
  double clearance = 0;             ///< m, minimum over the path, robot and held object to obstacles and table
  double target_clearance = 0;      ///< m, minimum over the path, hand to target or held object to support (set_down.h)
  double limit_margin = 0;          ///< rad, minimum over the path
  double max_speed = 0;             ///< rad/s, arm
  double path_length = 0;           ///< rad, Euclidean in joint space
  std::vector<Criterion> criteria;  ///< of the path; of a place also those of PlaceEnd, on and on_paper
  symbols::State before, after;     ///< ground literals from geometry and contact
  std::vector<std::string> objects;
  int steps = 0;                    ///< simulated
  std::vector<Survival> survivals;  ///< by amplitude; empty unless it was asked for and the final pose held
  std::vector<Contact> contacts;    ///< of Mode::execute, in the order of their beginnings; at most kMostContacts pairs
  int unlisted_contacts = 0;        ///< pairs that touched beyond those
  static constexpr int kMostContacts = 128;
};

}  // namespace primo::physics

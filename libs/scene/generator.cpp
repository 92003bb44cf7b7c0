#include "scene/generator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/random.h"
#include "robot/distance.h"
#include "scene/geometry.h"

namespace primo::scene {
namespace {

constexpr int kSceneTries = 200;     // whole scenes
constexpr int kObstacleTries = 200;  // places of one obstacle

bool apart(const Object& object, const std::vector<Object>& others, double least) {
  return std::all_of(others.begin(), others.end(), [&](const Object& other) { return gap(object, other) > least; });
}

bool any_touch(const std::vector<Object>& objects) {
  for (std::size_t i = 1; i < objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (gap(objects[i], objects[j]) <= 0) return true;
    }
  }
  return false;
}

Object cylinder_on(const Table& table, double radius, double x, double y) {
  Object object;
  object.radius = radius;
  object.position = {x, y, table.top_centre.z() + object.height / 2};
  return object;
}

/// An obstacle of random kind at a random place around the target. Draws the same count of numbers for every kind.
Object draw_obstacle(const RandomSceneSettings& settings, const Table& table, const Object& target, Random& random) {
  const double distance = random.uniform(settings.min_distance, settings.max_distance);
  const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
  const bool box = random.uniform() < settings.boxes;
  const Eigen::Vector3d half(random.uniform(0.025, 0.045), random.uniform(0.025, 0.045), random.uniform(0.04, 0.07));
  const double yaw = random.uniform(-std::numbers::pi / 2, std::numbers::pi / 2);
  Object object = cylinder_on(table, settings.radius, target.position.x() + distance * std::cos(angle),
                              target.position.y() + distance * std::sin(angle));
  if (box) {
    object.type = ShapeType::box;
    object.half_extents = half;
    object.position.z() = table.top_centre.z() + half.z();
    object.rpy.z() = yaw;
  }
  return object;
}

/// Adds one obstacle that touches nothing and stands on the table; false when no place was found.
bool add_obstacle(const RandomSceneSettings& settings, Scenario& scenario, Random& random) {
  for (int i = 0; i < kObstacleTries; ++i) {
    Object object = draw_obstacle(settings, scenario.table, scenario.objects.front(), random);
    if (!centre_over_table(object, scenario.table) || !apart(object, scenario.objects, settings.min_gap)) continue;
    const auto same = std::count_if(scenario.objects.begin(), scenario.objects.end(),
                                    [&](const Object& other) { return other.type == object.type; });
    object.name = std::string(1, object.type == ShapeType::box ? 'b' : 'c');
    object.name += std::to_string(same + 1);
    scenario.objects.push_back(std::move(object));
    return true;
  }
  return false;
}

Status check(const RandomSceneSettings& settings) {
  if (settings.min_obstacles < 0 || settings.min_obstacles > settings.max_obstacles) {
    return Error{Code::config, "random scene: 'min_obstacles' is " + std::to_string(settings.min_obstacles) +
                                   ", must be between 0 and 'max_obstacles' (" +
                                   std::to_string(settings.max_obstacles) + ")"};
  }
  if (!(settings.min_distance <= settings.max_distance) || !((settings.lower - settings.upper).maxCoeff() <= 0)) {
    return Error{Code::config,
                 "random scene: a lower bound is above its upper bound ('min_distance' and "
                 "'max_distance', 'lower' and 'upper')"};
  }
  return success();
}

/// Whether the robot overlaps no object but the one it holds.
bool clear_of(const robot::Robot& robot, const robot::Kinematics& kinematics, const Scenario& scenario) {
  for (const auto& link : robot.link_shapes()) {
    const Pose X_WG = robot.pose(kinematics, link);
    for (const auto& object : scenario.objects) {
      if (scenario.holds(object.name)) continue;
      const double radii = robot::bounding_radius(link.shape) + robot::bounding_radius(object.shape());
      if ((X_WG.translation() - object.position).norm() > radii) continue;
      if (robot::distance(link.shape, X_WG, object.shape(), object.X_WO()).distance < 0) return false;
    }
  }
  return true;
}

/// Displaces until objects are apart, on the table and `good`.
template <class Good>
Result<Displaced> displaced_until(const Scenario& base, double d, std::uint64_t seed, std::uint64_t index,
                                  int max_tries, Good good) {
  if (!(d >= 0 && d <= 0.5)) {
    return Error{Code::config, "displacement of scenario " + base.name + " is " + std::to_string(d) +
                                   " m, must be between 0 and 0.5"};
  }
  if (auto status = base.validate(); !status.ok()) return status.error().at("scenario " + base.name);
  Random random(seed, "displace", {index});
  Displaced result;
  result.scenario = base;
  result.scenario.name = base.name + "_" + std::to_string(index);
  result.scenario.camera_seed = random.bits();
  for (int i = 0; i < max_tries; ++i) {
    auto& objects = result.scenario.objects;
    bool fell = false;
    for (std::size_t k = 0; k < objects.size(); ++k) {
      if (base.holds(objects[k].name)) continue;  // it goes with the hand
      objects[k].position = base.objects[k].position;
      objects[k].position.x() += random.uniform(-d, d);
      objects[k].position.y() += random.uniform(-d, d);
      fell = fell || !centre_over_table(objects[k], base.table);
    }
    const bool touching = any_touch(objects);
    if (!fell && !touching && good(result.scenario)) return result;
    result.rejected_falling += fell;
    result.rejected_touching += !fell && touching;
    result.rejected_in_robot += !fell && !touching;
  }
  return Error{Code::config, "scenario " + base.name + ": no displacement by up to " + std::to_string(d) + " m in " +
                                 std::to_string(max_tries) + " draws kept objects apart (" +
                                 std::to_string(result.rejected_touching) + " touched), on the table (" +
                                 std::to_string(result.rejected_falling) + " fell) and out of the robot (" +
                                 std::to_string(result.rejected_in_robot) +
                                 " in it at its start); use a smaller displacement"};
}

}  // namespace

Result<Displaced> displace(const Scenario& base, double d, std::uint64_t seed, std::uint64_t index, int max_tries) {
  return displaced_until(base, d, seed, index, max_tries, [](const Scenario&) { return true; });
}

Result<Displaced> displace(const robot::Robot& robot, const Scenario& base, double d, std::uint64_t seed,
                           std::uint64_t index, int max_tries) {
  if (!base.robot_start.empty() && static_cast<int>(base.robot_start.size()) != robot.joints()) {
    return Error{Code::config, "scenario " + base.name + ": 'robot_start' has " +
                                   std::to_string(base.robot_start.size()) + " joint angles, robot " + robot.name() +
                                   " has " + std::to_string(robot.joints())};
  }
  Eigen::VectorXd start = robot.home();
  if (!base.robot_start.empty()) start = Eigen::Map<const Eigen::VectorXd>(base.robot_start.data(), robot.joints());
  const robot::Kinematics kinematics = robot.forward(start);
  return displaced_until(base, d, seed, index, max_tries,
                         [&](const Scenario& scenario) { return clear_of(robot, kinematics, scenario); });
}

Result<Scenario> random_scenario(const RandomSceneSettings& settings, std::uint64_t seed, std::uint64_t index) {
  PRIMO_TRY(check(settings));
  Random random(seed, "random scene", {index});
  Scenario scenario;
  scenario.name = "random_" + std::to_string(seed) + "_" + std::to_string(index);
  scenario.action = {"grasp", "c1"};
  scenario.cameras = default_cameras(scenario.table, settings.depth_noise);
  scenario.camera_seed = random.bits();
  const auto range = static_cast<std::uint64_t>(settings.max_obstacles - settings.min_obstacles + 1);
  const int obstacles = settings.min_obstacles + static_cast<int>(random.below(range));
  for (int i = 0; i < kSceneTries; ++i) {
    const double y = random.uniform(settings.lower.y(), settings.upper.y());
    const double x = random.uniform(settings.lower.x(), settings.upper.x());
    Object target = cylinder_on(scenario.table, settings.radius, x, y);
    target.name = "c1";
    if (!centre_over_table(target, scenario.table)) continue;
    scenario.objects = {target};
    int placed = 0;
    while (placed < obstacles && add_obstacle(settings, scenario, random)) ++placed;
    if (placed == obstacles) return scenario;
  }
  return Error{Code::config, "random scene " + std::to_string(index) + " of seed " + std::to_string(seed) +
                                 ": no room for " + std::to_string(obstacles) + " obstacles at " +
                                 std::to_string(settings.min_distance) + " … " + std::to_string(settings.max_distance) +
                                 " m from the target in " + std::to_string(kSceneTries) +
                                 " draws; use fewer obstacles or a wider ring"};
}

}  // namespace primo::scene

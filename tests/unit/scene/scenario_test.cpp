#include "scene/scenario.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "core/random.h"
#include "scene/geometry.h"
#include "scene/reach.h"

namespace primo::scene {
namespace {

const std::string kGood =
    "name: s\naction: [grasp, c1]\nobjects:\n"
    "  - {name: c1, position: [0.8, 0.0, 0.724]}\n"
    "  - {name: b1, type: box, half_extents: [0.03, 0.04, 0.05], position: [0.8, 0.2, 0.72], rpy: [0, 0, 0.4]}\n";

Scenario good() {
  auto scenario = read_scenario_text(kGood, "s.yaml");
  EXPECT_TRUE(scenario.ok()) << scenario.error().message;
  return *scenario;
}

std::string refusal(const Scenario& scenario) {
  const auto status = scenario.validate();
  EXPECT_FALSE(status.ok());
  if (status.ok()) return "";
  EXPECT_EQ(status.error().code, Code::config);
  return status.error().message;
}

bool says(const std::string& message, const std::string& part) { return message.find(part) != std::string::npos; }

TEST(Scenario, the_example_is_valid_and_has_two_cameras) {
  const auto scenario = read_scenario(std::string(PRIMO_SOURCE_DIR) + "/configs/scenarios/example.yaml");
  ASSERT_TRUE(scenario.ok()) << scenario.error().message;
  EXPECT_EQ(scenario->cameras.size(), 2U);
  EXPECT_TRUE(scenario->object("c1"));
  EXPECT_FALSE(scenario->object("c9"));
}

TEST(Scenario, a_written_scenario_reads_back_with_the_same_identity) {
  Scenario scenario = good();
  scenario.objects[0].position.x() = 0.1 + 0.7;  // no short decimal
  scenario.camera_seed = std::numeric_limits<std::uint64_t>::max();
  const auto path = std::filesystem::temp_directory_path() / ("primo_scenario_" + scene_id(scenario) + ".yaml");
  ASSERT_TRUE(write_scenario(path, scenario).ok());
  const auto again = read_scenario(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(scene_id(*again), scene_id(scenario));
  EXPECT_EQ(again->objects[0].position, scenario.objects[0].position);
  EXPECT_EQ(again->camera_seed, scenario.camera_seed);
}

TEST(Scenario, the_identity_is_of_the_content_and_not_of_the_name) {
  const Scenario scenario = good();
  Scenario other = scenario;
  other.name = "another";
  EXPECT_EQ(scene_id(other), scene_id(scenario));
  EXPECT_EQ(scene_id(scenario).size(), 16U);
  other.objects[0].position.x() += 1e-12;
  EXPECT_NE(scene_id(other), scene_id(scenario));
  other = scenario;
  other.camera_seed += 1;
  EXPECT_NE(scene_id(other), scene_id(scenario));
}

TEST(Scenario, a_missing_file_is_one_clear_error) {
  const auto scenario = read_scenario("no/such/file.yaml");
  ASSERT_FALSE(scenario.ok());
  EXPECT_TRUE(says(scenario.error().message, "no/such/file.yaml")) << scenario.error().message;
}

TEST(Scenario, an_unknown_key_is_refused_with_its_line) {
  const auto scenario = read_scenario_text(kGood + "actoin: 1\n", "s.yaml");
  ASSERT_FALSE(scenario.ok());
  EXPECT_TRUE(says(scenario.error().message, "s.yaml:6: unknown key 'actoin'")) << scenario.error().message;
}

TEST(Scenario, overlapping_objects_are_refused_by_name_and_depth) {
  Scenario scenario = good();
  scenario.objects[1].position = {0.8 + 0.0375 + 0.03 - 0.004, 0, 0.72};
  scenario.objects[1].rpy.setZero();
  const std::string message = refusal(scenario);
  EXPECT_TRUE(says(message, "'c1' and 'b1' overlap by 0.004 m")) << message;
  scenario.objects[1].position.x() += 0.005;
  EXPECT_TRUE(scenario.validate().ok());
}

TEST(Scenario, an_object_that_floats_or_sinks_is_refused_with_the_right_height) {
  Scenario scenario = good();
  scenario.objects[0].position.z() += 0.0009;
  EXPECT_TRUE(scenario.validate().ok());
  scenario.objects[0].position.z() += 0.1;
  EXPECT_TRUE(says(refusal(scenario), "must rest on it (within 0.001 m): position[2] would be 0.724"));
  scenario.objects[0].position.z() -= 0.2;
  EXPECT_TRUE(says(refusal(scenario), "object 'c1': its lowest point"));
}

TEST(Scenario, a_lying_cylinder_rests_on_its_side) {
  Scenario scenario = good();
  scenario.objects[0].rpy = {0, std::numbers::pi / 2, 0.3};
  scenario.objects[0].position.z() = 0.67 + 0.0375;
  EXPECT_TRUE(scenario.validate().ok()) << scenario.validate().error().message;
}

TEST(Scenario, an_object_beyond_the_edge_is_refused) {
  Scenario scenario = good();
  scenario.objects[0].position.x() = 0.8 + 0.26 + 1e-6;
  EXPECT_TRUE(says(refusal(scenario), "beyond the table's edge"));
  scenario.objects[0].position.x() = 0.8 + 0.26 - 1e-6;
  EXPECT_TRUE(scenario.validate().ok());
}

TEST(Scenario, names_must_be_unique_symbols) {
  Scenario scenario = good();
  scenario.objects[1].name = "c1";
  EXPECT_TRUE(says(refusal(scenario), "given twice"));
  scenario.objects[1].name = "table";
  EXPECT_TRUE(says(refusal(scenario), "given twice"));
  for (const std::string name : {"", "C1", "1c", "a b", "a\"b", "floor"}) {
    scenario.objects[1].name = name;
    EXPECT_FALSE(scenario.validate().ok()) << name;
  }
}

TEST(Scenario, the_action_must_name_objects_of_the_scene) {
  Scenario scenario = good();
  scenario.action = {"grasp", "c7"};
  EXPECT_TRUE(says(refusal(scenario), "names 'c7', which is no object of the scenario; objects are c1, b1"));
  scenario.action = {"grasp"};
  EXPECT_TRUE(says(refusal(scenario), "must have one"));
  scenario.action = {};
  EXPECT_TRUE(says(refusal(scenario), "'action' is empty"));
  scenario.action = {"stack", "c1", "table"};
  EXPECT_TRUE(scenario.validate().ok());
}

/// c1 held 10 cm over the table, to be placed on b1.
Scenario holding() {
  Scenario scenario = good();
  scenario.objects[0].position.z() += 0.1;
  scenario.robot_start.assign(14, 0.0);
  scenario.held = Held{"c1", {0, 0, 0.01}, {0.1, 0, 0}};
  scenario.action = {"place", "c1", "b1"};
  return scenario;
}

TEST(Scenario, an_object_in_the_hand_need_not_rest_on_the_table_but_everything_else_must_fit) {
  EXPECT_TRUE(holding().validate().ok());
  Scenario scenario = holding();
  const auto again = read_scenario_text(config::dump(scenario), "text");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(config::dump(*again), config::dump(scenario));
  EXPECT_NE(scene_id(*again), scene_id(good()));
  EXPECT_EQ(config::dump(good()).find("held"), std::string::npos) << "scenes without have no such key";
  scenario.action = {"place", "c1", "table"};
  EXPECT_TRUE(scenario.validate().ok());
  scenario.action = {"place", "b1", "c1"};
  EXPECT_TRUE(says(refusal(scenario), "the hand does not hold 'b1'"));
  scenario.action = {"place", "c1", "c1"};
  EXPECT_TRUE(says(refusal(scenario), "on itself"));
  scenario.action = {"place", "c1"};
  EXPECT_TRUE(says(refusal(scenario), "must have two"));
  scenario.action = {"grasp", "b1"};
  EXPECT_TRUE(says(refusal(scenario), "free hand"));
  scenario = holding();
  scenario.held->object = "c9";
  EXPECT_TRUE(says(refusal(scenario), "'held.object' is 'c9'"));
  scenario = holding();
  scenario.robot_start.clear();
  EXPECT_TRUE(says(refusal(scenario), "'held' needs 'robot_start'"));
  scenario = holding();
  scenario.objects[0].position.z() -= 0.11;
  EXPECT_TRUE(says(refusal(scenario), "deep in the table"));
  scenario = holding();
  scenario.held->position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(refusal(scenario), "'held.position[0]'"));
}

TEST(Scenario, values_that_came_by_another_way_than_a_file_meet_the_same_bounds) {
  Scenario scenario = good();
  scenario.objects[1].half_extents.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(refusal(scenario), "'objects[1].half_extents[1]'"));
  scenario = good();
  scenario.objects[0].radius = 9;
  EXPECT_TRUE(says(refusal(scenario), "'objects[0].radius' is 9"));
  scenario = good();
  scenario.cameras[1].fov_y = 3.2;
  EXPECT_TRUE(says(refusal(scenario), "'cameras[1].fov_y'"));
  scenario = good();
  scenario.cameras[0].look_at = scenario.cameras[0].position;
  EXPECT_TRUE(says(refusal(scenario), "'look_at' is at the camera itself"));
  scenario = good();
  scenario.robot_start = {0, std::numeric_limits<double>::infinity()};
  EXPECT_TRUE(says(refusal(scenario), "'robot_start[1]'"));
  scenario = good();
  scenario.objects[0].type = ShapeType::capsule;
  EXPECT_TRUE(says(refusal(scenario), "must be cylinder or box"));
}

Object random_object(Random& random, bool level) {
  Object object;
  object.type = random.below(2) ? ShapeType::box : ShapeType::cylinder;
  object.radius = random.uniform(0.02, 0.06);
  object.height = random.uniform(0.05, 0.15);
  object.half_extents = {random.uniform(0.02, 0.06), random.uniform(0.02, 0.06), random.uniform(0.02, 0.06)};
  object.position = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)};
  object.rpy = {level ? 0 : random.uniform(-2, 2), level ? 0 : random.uniform(-2, 2), random.uniform(-3, 3)};
  return object;
}

/// The closest point of a solid to p, by its own closed form: independent of the footprints in geometry.cpp.
Eigen::Vector3d project(const Object& object, const Eigen::Vector3d& p) {
  const Pose X = object.X_WO();
  Eigen::Vector3d q = X.inverse() * p;
  if (object.type == ShapeType::box) {
    q = q.cwiseMax(-object.half_extents).cwiseMin(object.half_extents);
  } else {
    const double r = q.head<2>().norm();
    if (r > object.radius) q.head<2>() *= object.radius / r;
    q.z() = std::clamp(q.z(), -object.height / 2, object.height / 2);
  }
  return X * q;
}

/// Distance of two convex solids by alternating projections (von Neumann), which converges to it from above.
double projected_distance(const Object& a, const Object& b) {
  Eigen::Vector3d p = a.position, q = b.position;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d next = project(a, q);
    const double moved = (next - p).norm();
    p = next;
    q = project(b, p);
    if (i > 0 && moved < 1e-10) break;
  }
  return (p - q).norm();
}

TEST(Geometry, gaps_of_upright_objects_are_exact_and_those_of_tilted_ones_are_lower_bounds) {
  Random random(11, "gap test");
  int apart = 0, overlapping = 0;
  for (int i = 0; i < 400; ++i) {
    const bool level = i % 2 == 0;
    const Object a = random_object(random, level), b = random_object(random, level);
    const double expected = projected_distance(a, b), actual = gap(a, b);
    EXPECT_NEAR(gap(b, a), actual, 1e-12);
    if (level) {
      EXPECT_NEAR(std::max(actual, 0.0), expected, 2e-5) << i;
    } else {
      EXPECT_LE(actual, expected + 1e-9) << i;
    }
    (expected > 1e-4 ? apart : overlapping)++;
  }
  EXPECT_GT(apart, 50);
  EXPECT_GT(overlapping, 50);
}

TEST(Geometry, height_over_the_table_is_of_the_lowest_corner) {
  Random random(12, "height test");
  const Table table;
  for (int i = 0; i < 100; ++i) {
    Object box = random_object(random, false);
    box.type = ShapeType::box;
    double lowest = 1e9;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      lowest = std::min(lowest, (box.X_WO() * sign.cwiseProduct(box.half_extents)).z());
    }
    EXPECT_NEAR(height_over_table(box, table), lowest - 0.67, 1e-12);
  }
}

TEST(Reach, a_target_too_far_or_a_start_of_wrong_length_is_one_clear_error) {
  const auto robot = robot::Robot::load(std::string(PRIMO_SOURCE_DIR) + "/configs/robots/schunk_lwa3_sdh2.yaml");
  ASSERT_TRUE(robot.ok()) << robot.error().message;
  Scenario scenario = good();
  EXPECT_TRUE(check_robot(scenario, *robot).ok());
  // Published segments from the first joint's axis to the grasp centre, the arm stretched out.
  const double stretched = 0.175 + 0.175 + 0.1515 + 0.1515 + 0.12575 + 0.12575 + 0.32;
  EXPECT_LE(reach(*robot).longest, stretched + 0.15);
  EXPECT_GE(reach(*robot).longest, stretched - 0.15);
  for (auto& object : scenario.objects) object.position.x() += 0.9;
  scenario.table.top_centre.x() += 0.9;
  ASSERT_TRUE(scenario.validate().ok());
  auto status = check_robot(scenario, *robot);
  ASSERT_FALSE(status.ok());
  EXPECT_TRUE(says(status.error().message, "object 'c1' cannot be reached")) << status.error().message;
  scenario = good();
  scenario.robot_start = {0, 0, 0};
  status = check_robot(scenario, *robot);
  ASSERT_FALSE(status.ok());
  EXPECT_TRUE(says(status.error().message, "must have 14")) << status.error().message;
  scenario.robot_start.assign(14, 0.0);
  scenario.robot_start[1] = 5;
  status = check_robot(scenario, *robot);
  ASSERT_FALSE(status.ok());
  EXPECT_TRUE(says(status.error().message, "beyond the limits of joint arm_2")) << status.error().message;
}

}  // namespace
}  // namespace primo::scene

#include "scene/generator.h"

#include <gtest/gtest.h>

#include <set>

namespace primo::scene {
namespace {

Scenario two_cylinders(double distance) {
  Scenario scenario;
  scenario.name = "base";
  scenario.action = {"grasp", "c1"};
  for (int i = 0; i < 2; ++i) {
    Object object;
    object.name = i ? "c2" : "c1";
    object.position = {0.8, i * distance, 0.724};
    scenario.objects.push_back(object);
  }
  return scenario;
}

TEST(Generator, displaced_objects_stay_within_d_apart_and_on_the_table) {
  const Scenario base = two_cylinders(0.09);
  int touching = 0;
  double widest = 0;
  for (std::uint64_t i = 0; i < 500; ++i) {
    const auto displaced = displace(base, 0.03, 5, i);
    ASSERT_TRUE(displaced.ok()) << displaced.error().message;
    touching += displaced->rejected_touching;
    const auto& objects = displaced->scenario.objects;
    for (std::size_t k = 0; k < 2; ++k) {
      const Eigen::Vector3d move = objects[k].position - base.objects[k].position;
      EXPECT_LE(move.cwiseAbs().maxCoeff(), 0.03);
      EXPECT_EQ(move.z(), 0);
      widest = std::max(widest, move.cwiseAbs().maxCoeff());
    }
    EXPECT_GT((objects[0].position - objects[1].position).norm(), 2 * 0.0375);
    EXPECT_TRUE(displaced->scenario.validate().ok());
  }
  EXPECT_GT(widest, 0.0295);
  EXPECT_GT(touching, 50);
}

TEST(Generator, the_share_of_rejected_draws_is_the_probability_of_touching_or_falling) {
  // One object 1 cm from the edge, moved by ±2 cm: it falls for a quarter of the draws.
  Scenario edge = two_cylinders(0.1);
  edge.objects.resize(1);
  edge.objects[0].position.x() = 0.8 + 0.26 - 0.01;
  double accepted = 0, fell = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const auto displaced = displace(edge, 0.02, 1, i);
    ASSERT_TRUE(displaced.ok());
    accepted += 1;
    fell += displaced->rejected_falling;
    EXPECT_EQ(displaced->rejected_touching, 0);
    EXPECT_LE(displaced->scenario.objects[0].position.x(), 1.06);
  }
  EXPECT_NEAR(fell / (fell + accepted), 0.25, 0.03);
  // Two squares of half side a, moved along x and y by ±d: |Δx| and |Δy| of the difference have triangular densities on
  // ±2d, and they overlap where both are below 2a. Here the distance is s along x, so P = P(Δx < 2a − s) · P(|Δy| <
  // 2a).
  Scenario boxes = two_cylinders(0.1);
  const double a = 0.04, d = 0.03, s = 0.1;
  for (std::size_t k = 0; k < 2; ++k) {
    boxes.objects[k].type = ShapeType::box;
    boxes.objects[k].half_extents = {a, a, 0.054};
    boxes.objects[k].position = {0.75 + s * static_cast<double>(k), 0, 0.724};
  }
  double drawn = 0, touched = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const auto displaced = displace(boxes, d, 2, i);
    ASSERT_TRUE(displaced.ok());
    drawn += 1 + displaced->rejected();
    touched += displaced->rejected_touching;
  }
  const double below = 2 * a - s + 2 * d;                  // Δx in [−2d, 2a − s]: the triangle's left part
  const double probability = below * below / (8 * d * d);  // |Δy| ≤ 2d < 2a always
  EXPECT_NEAR(touched / drawn, probability, 0.03);
}

TEST(Generator, the_same_seed_and_index_give_the_same_scenario_in_any_order) {
  const Scenario base = two_cylinders(0.12);
  const auto later = displace(base, 0.05, 9, 17);
  ASSERT_TRUE(displace(base, 0.05, 9, 3).ok());
  EXPECT_EQ(config::dump(displace(base, 0.05, 9, 17)->scenario), config::dump(later->scenario));
  EXPECT_NE(scene_id(displace(base, 0.05, 9, 18)->scenario), scene_id(later->scenario));
  EXPECT_NE(scene_id(displace(base, 0.05, 10, 17)->scenario), scene_id(later->scenario));
  const RandomSceneSettings settings;
  EXPECT_EQ(config::dump(*random_scenario(settings, 4, 2)), config::dump(*random_scenario(settings, 4, 2)));
}

TEST(Generator, what_the_hand_holds_is_not_displaced) {
  Scenario base = random_scenario({}, 3, 1).value();
  base.objects[0].position.z() += 0.15;
  base.robot_start.assign(14, 0.0);
  base.held = Held{"c1"};
  base.action = {"place", "c1", base.objects[1].name};
  for (std::uint64_t index = 0; index < 20; ++index) {
    const auto moved = displace(base, 0.03, 4, index);
    ASSERT_TRUE(moved.ok()) << moved.error().message;
    EXPECT_EQ(moved->scenario.objects[0].position, base.objects[0].position);
    EXPECT_NE(moved->scenario.objects[1].position, base.objects[1].position);
    EXPECT_LE((moved->scenario.objects[1].position - base.objects[1].position).cwiseAbs().maxCoeff(), 0.03);
  }
}

TEST(Generator, no_displacement_leaves_positions_as_they_are) {
  const Scenario base = two_cylinders(0.12);
  const auto displaced = displace(base, 0, 1, 1);
  ASSERT_TRUE(displaced.ok());
  EXPECT_EQ(displaced->scenario.objects[1].position, base.objects[1].position);
}

TEST(Generator, hopeless_requests_end_with_the_counts_of_rejections) {
  // 36 cylinders a hundredth of a millimetre apart: a displacement that parts all 60 pairs of neighbours is out of
  // reach.
  Scenario crowded = two_cylinders(0.1);
  const Object cylinder = crowded.objects[0];
  crowded.objects.clear();
  for (int i = 0; i < 36; ++i) {
    crowded.objects.push_back(cylinder);
    crowded.objects.back().name = "c" + std::to_string(i + 1);
    crowded.objects.back().position.x() = 0.6 + 0.07501 * (i % 6);
    crowded.objects.back().position.y() = -0.19 + 0.07501 * (i / 6);
  }
  ASSERT_TRUE(crowded.validate().ok()) << crowded.validate().error().message;
  const auto displaced = displace(crowded, 0.01, 1, 1, 50);
  ASSERT_FALSE(displaced.ok());
  EXPECT_NE(displaced.error().message.find("in 50 draws kept objects apart (50 touched)"), std::string::npos)
      << displaced.error().message;
  const auto invalid = displace(crowded, -1, 1, 1);
  ASSERT_FALSE(invalid.ok());
  EXPECT_NE(invalid.error().message.find("must be between 0 and 0.5"), std::string::npos);
  RandomSceneSettings settings;
  settings.min_obstacles = settings.max_obstacles = 12;
  const auto impossible = random_scenario(settings, 1, 1);
  ASSERT_FALSE(impossible.ok());
  EXPECT_NE(impossible.error().message.find("no room for 12 obstacles"), std::string::npos);
  settings.max_obstacles = 2;
  EXPECT_FALSE(random_scenario(settings, 1, 1).ok());
}

TEST(Generator, random_scenes_have_cylinders_of_the_radius_asked_for_where_they_have_them_anyway) {
  RandomSceneSettings slim;
  slim.radius = 0.025;
  slim.boxes = 0;
  slim.min_obstacles = slim.max_obstacles = 1;
  RandomSceneSettings wide = slim;
  wide.radius = RandomSceneSettings{}.radius;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto a = random_scenario(slim, 3, i), b = random_scenario(wide, 3, i);
    ASSERT_TRUE(a.ok() && b.ok());
    for (const auto& object : a->objects) EXPECT_EQ(object.radius, 0.025);
    for (const auto& object : b->objects) EXPECT_EQ(object.radius, 0.0375);
    EXPECT_EQ(a->objects.front().position, b->objects.front().position);
  }
}

TEST(Generator, random_scenes_are_valid_and_their_obstacles_stand_in_the_ring) {
  RandomSceneSettings settings;
  std::set<std::string> ids;
  int boxes = 0, obstacles = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const auto scenario = random_scenario(settings, 3, i);
    ASSERT_TRUE(scenario.ok()) << scenario.error().message;
    ASSERT_TRUE(scenario->validate().ok()) << scenario->validate().error().message;
    ids.insert(scene_id(*scenario));
    const Eigen::Vector3d target = scenario->object("c1")->position;
    EXPECT_GE(target.x(), settings.lower.x());
    EXPECT_LE(target.y(), settings.upper.y());
    EXPECT_GE(scenario->objects.size(), 2U);
    EXPECT_LE(scenario->objects.size(), 4U);
    for (const auto& object : scenario->objects) {
      if (object.name == "c1") continue;
      const double distance = (object.position - target).head<2>().norm();
      EXPECT_GE(distance, settings.min_distance - 1e-12);
      EXPECT_LE(distance, settings.max_distance + 1e-12);
      ++obstacles;
      boxes += object.type == ShapeType::box;
    }
  }
  EXPECT_EQ(ids.size(), 300U);
  EXPECT_GT(boxes, obstacles / 8);
  EXPECT_LT(boxes, obstacles / 2);
}

}  // namespace
}  // namespace primo::scene

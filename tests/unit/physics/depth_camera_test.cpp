#include "physics/depth_camera.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <iostream>
#include <tuple>

#include "physics/model.h"
#include "scene/generator.h"
#include "scene/perception.h"
#include "scene/shape_fit.h"

namespace primo::physics {
namespace {

using Eigen::Vector3d;

scene::Scenario scene_of(std::uint64_t index, int obstacles, double noise) {
  scene::RandomSceneSettings settings;
  settings.min_obstacles = settings.max_obstacles = obstacles;
  settings.depth_noise = noise;
  auto scenario = scene::random_scenario(settings, 21, index);
  EXPECT_TRUE(scenario.ok()) << scenario.error().message;
  return *scenario;
}

/// m, from p to the nearest surface of the scene, by the shapes' own formulas.
double to_surface(const scene::Scenario& scenario, const Vector3d& p) {
  double nearest = std::abs(p.z());  // the floor
  const auto& table = scenario.table;
  scene::ShapeFit solid;
  solid.type = ShapeType::box;
  solid.X_WO = pose(table.top_centre - Vector3d(0, 0, table.thickness / 2));
  solid.shape = {ShapeType::box, {table.size.x() / 2, table.size.y() / 2, table.thickness / 2}};
  nearest = std::min(nearest, std::abs(solid.distance(p)));
  for (const auto& object : scenario.objects) {
    solid.type = object.type;
    solid.X_WO = object.X_WO();
    solid.shape = object.shape();
    nearest = std::min(nearest, std::abs(solid.distance(p)));
  }
  return nearest;
}

TEST(DepthCamera, a_pose_looks_at_its_point_with_the_world_upright) {
  scene::Camera camera;
  camera.position = {0.8, -0.9, 1.35};
  camera.look_at = {0.8, 0.0, 0.70};
  const Pose X_WC = camera_pose(camera);
  EXPECT_NEAR((X_WC.linear().transpose() * X_WC.linear() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
  EXPECT_NEAR(X_WC.linear().determinant(), 1, 1e-12);
  const Vector3d seen = X_WC.inverse() * camera.look_at;
  EXPECT_NEAR(seen.head<2>().norm(), 0, 1e-12);
  EXPECT_GT(seen.z(), 0);
  EXPECT_NEAR(X_WC.linear()(2, 0), 0, 1e-12);  // x is level
  EXPECT_LT(X_WC.linear()(2, 1), 0);           // y points down
  camera.look_at = camera.position - Vector3d(0, 0, 1);
  EXPECT_TRUE(camera_pose(camera).matrix().allFinite());
}

TEST(DepthCamera, points_without_noise_lie_on_the_surfaces_and_fill_the_picture) {
  const auto scenario = scene_of(0, 2, 0);
  const auto clouds = render_depth(scenario);
  ASSERT_TRUE(clouds.ok()) << clouds.error().message;
  ASSERT_EQ(clouds->size(), 2U);
  for (const auto& cloud : *clouds) {
    EXPECT_EQ(cloud.points.size(), 320U * 240U);  // floor behind everything
    double worst = 0;
    for (const auto& p : cloud.points) worst = std::max(worst, to_surface(scenario, cloud.X_WC * p.cast<double>()));
    EXPECT_LT(worst, 2e-6);  // float
  }
}

TEST(DepthCamera, every_pixel_sees_what_a_ray_through_the_whole_scene_meets_first) {
  std::size_t pixels = 0;
  for (std::uint64_t index = 0; index < 6; ++index) {
    auto scenario = scene_of(index, 4, 0);
    scenario.objects[0].rpy = {0.3, 1.2, 0.4 + static_cast<double>(index)};
    // From the usual places, from close by, from beneath the table's edge, and past the objects.
    scenario.cameras.resize(5, scenario.cameras.front());
    const Vector3d object = scenario.objects[1].position;
    scenario.cameras[2].position = object + Vector3d(-0.12, 0.05, 0.1);
    scenario.cameras[2].look_at = object;
    scenario.cameras[3].position = scenario.table.top_centre + Vector3d(-0.9, 0.2, -0.1);
    scenario.cameras[3].look_at = scenario.table.top_centre;
    scenario.cameras[4].look_at = scenario.cameras[4].position + Vector3d(0.2, 1, -0.2);
    for (auto& camera : scenario.cameras) std::tie(camera.width, camera.height) = std::pair(97, 71);
    const auto clouds = render_depth(scenario, {.range = 50});
    ASSERT_TRUE(clouds.ok()) << clouds.error().message;
    const auto model = assemble(nullptr, scenario);
    ASSERT_TRUE(model.ok());
    Data data(*model);
    mj_kinematics(model->get(), data.get());
    for (std::size_t i = 0; i < clouds->size(); ++i) {
      const auto& cloud = (*clouds)[i];
      const double focal = 71 / 2.0 / std::tan(scenario.cameras[i].fov_y / 2);
      const Vector3d origin = cloud.X_WC.translation();
      std::size_t seen = 0;
      for (int pixel = 0; pixel < 97 * 71; ++pixel, ++pixels) {
        const Vector3d ray_C =
            Vector3d((pixel % 97 + 0.5 - 97 / 2.0) / focal, (pixel / 97 + 0.5 - 71 / 2.0) / focal, 1);
        const Vector3d ray_W = cloud.X_WC.linear() * ray_C.normalized();
        int geom = -1;
        const double hit = mj_ray(model->get(), data.get(), origin.data(), ray_W.data(), nullptr, 1, -1, &geom);
        if (hit < 0 || hit > 50) continue;
        ASSERT_LT(seen, cloud.points.size());
        EXPECT_NEAR(cloud.points[seen++].cast<double>().norm(), hit, 1e-5) << "camera " << i << " pixel " << pixel;
      }
      EXPECT_EQ(seen, cloud.points.size());
    }
  }
  EXPECT_EQ(pixels, 6U * 5 * 97 * 71);
}

TEST(DepthCamera, below_the_lowest_height_points_are_left_out_and_no_other_changes) {
  for (const double noise : {0.0, 0.002, 0.05}) {
    auto scenario = scene_of(3, 3, noise);
    scenario.cameras.resize(3, scenario.cameras.front());
    scenario.cameras[2].position = scenario.table.top_centre + Vector3d(-0.9, 0.2, -0.1);
    scenario.cameras[2].look_at = scenario.table.top_centre;
    const auto whole = render_depth(scenario);
    ASSERT_TRUE(whole.ok());
    for (const double lowest : {-1.0, 0.0, 1e-6, 0.02, scenario.table.top_centre.z() + 0.01, 5.0}) {
      const auto cropped = render_depth(scenario, {.lowest = lowest});
      ASSERT_TRUE(cropped.ok());
      for (std::size_t i = 0; i < whole->size(); ++i) {
        auto kept = (*whole)[i];
        std::erase_if(kept.points, [&](const Eigen::Vector3f& p) {
          return lowest > 0 && (kept.X_WC * p.cast<double>()).z() < lowest;
        });
        EXPECT_EQ(kept.points, (*cropped)[i].points) << "noise " << noise << " lowest " << lowest << " camera " << i;
      }
    }
  }
  EXPECT_FALSE(render_depth(scene_of(0, 1, 0), {.lowest = std::nan("")}).ok());
}

TEST(DepthCamera, what_is_perceived_does_not_depend_on_points_of_the_floor) {
  std::size_t left_out = 0, all = 0;
  for (std::uint64_t index = 0; index < 12; ++index) {
    const auto scenario = scene_of(index, 3, index % 3 == 0 ? 0.0 : index % 3 == 1 ? 0.002 : 0.02);
    const double lowest = scene::lowest_of_interest(scenario);
    EXPECT_GT(lowest, 0.1);
    const auto whole = render_depth(scenario), cropped = render_depth(scenario, {.lowest = lowest});
    ASSERT_TRUE(whole.ok() && cropped.ok());
    for (std::size_t i = 0; i < whole->size(); ++i) {
      all += (*whole)[i].points.size();
      left_out += (*whole)[i].points.size() - (*cropped)[i].points.size();
    }
    auto request = scene::perception_request(scenario, *whole);
    request.octree = false;
    const auto expected = scene::perceive(request);
    request.clouds = *cropped;
    const auto found = scene::perceive(request);
    ASSERT_EQ(expected.ok(), found.ok());
    if (!expected.ok()) continue;
    EXPECT_EQ(expected->table.top_centre, found->table.top_centre);
    EXPECT_EQ(expected->table.size, found->table.size);
    ASSERT_EQ(expected->objects.size(), found->objects.size());
    for (std::size_t i = 0; i < expected->objects.size(); ++i) {
      const auto& a = expected->objects[i];
      const auto& b = found->objects[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.X_WO.matrix(), b.X_WO.matrix());
      EXPECT_EQ(a.shape.size, b.shape.size);
      EXPECT_EQ(a.points, b.points);
    }
  }
  EXPECT_GT(left_out, all / 2);
}

TEST(DepthCamera, a_scene_may_hold_as_many_objects_as_a_file) {
  auto scenario = scene_of(0, 0, 0);
  scene::Object object = scenario.objects[0];
  scenario.objects.clear();
  object.radius = 0.01;
  for (int i = 0; i < 64; ++i) {
    object.name = "o" + std::to_string(i);
    const Vector3d offset(0.03 * (i % 8) - 0.12, 0.03 * (i / 8) - 0.12, object.height / 2);
    object.position = scenario.table.top_centre + offset;
    scenario.objects.push_back(object);
  }
  scenario.action = {"grasp", "o0"};
  const auto clouds = render_depth(scenario);
  EXPECT_TRUE(clouds.ok()) << clouds.error().message;
}

TEST(DepthCamera, noise_is_along_the_ray_with_the_given_deviation) {
  auto scenario = scene_of(0, 2, 0);
  const auto exact = render_depth(scenario);
  for (auto& camera : scenario.cameras) camera.depth_noise = 0.002;
  const auto noisy = render_depth(scenario);
  ASSERT_TRUE(exact.ok() && noisy.ok());
  double sum = 0, squares = 0, across = 0;
  const auto& a = (*exact)[1].points;
  const auto& b = (*noisy)[1].points;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = b[i].cast<double>().norm() - a[i].cast<double>().norm();
    sum += error;
    squares += error * error;
    across = std::max(across, b[i].cast<double>().normalized().cross(a[i].cast<double>().normalized()).norm());
  }
  const auto n = static_cast<double>(a.size());
  EXPECT_NEAR(sum / n, 0, 5 * 0.002 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.002, 5 * 0.002 / std::sqrt(2 * n));
  EXPECT_LT(across, 1e-6);
}

TEST(DepthCamera, the_same_scenario_gives_the_same_bytes_and_another_seed_other_noise) {
  auto scenario = scene_of(3, 2, 0.002);
  const auto first = render_depth(scenario), second = render_depth(scenario);
  ASSERT_TRUE(first.ok() && second.ok());
  for (std::size_t i = 0; i < first->size(); ++i) {
    const auto& a = (*first)[i].points;
    const auto& b = (*second)[i].points;
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]), 0);
  }
  EXPECT_NE((*first)[0].points[100], (*first)[1].points[100]);
  scenario.camera_seed += 1;
  const auto other = render_depth(scenario);
  ASSERT_TRUE(other.ok());
  EXPECT_NE((*other)[0].points[100], (*first)[0].points[100]);
}

TEST(DepthCamera, an_invalid_scenario_is_refused) {
  auto scenario = scene_of(0, 1, 0);
  scenario.objects[0].position.x() = std::nan("");
  EXPECT_FALSE(render_depth(scenario).ok());
  EXPECT_FALSE(render_depth(scene_of(0, 1, 0), {.range = 0}).ok());
}

struct Errors {
  int objects = 0, missing = 0, wrong_type = 0;
  double max_position = 0, sum_position = 0, max_radius = 0, max_height = 0, max_table_height = 0, max_table_size = 0;
  double max_half_extent = 0, max_yaw = 0;
};

void compare_cylinder(const scene::Object& truth, const scene::ObjectEstimate& found, Errors& errors) {
  errors.max_radius = std::max(errors.max_radius, std::abs(found.shape.size.x() - truth.radius));
  errors.max_height = std::max(errors.max_height, std::abs(2 * found.shape.size.y() - truth.height));
}

void compare_box(const scene::Object& truth, const scene::ObjectEstimate& found, Errors& errors) {
  // A box has four equal poses about the vertical: compare with the nearest.
  double best = 1e9, extent = 0;
  const Eigen::Matrix3d R = found.X_WO.linear().transpose() * truth.X_WO().linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  for (int turn = -2; turn <= 2; ++turn) {
    const double difference = std::abs(yaw - turn * std::numbers::pi / 2);
    if (difference >= best) continue;
    best = difference;
    Vector3d half = truth.half_extents;
    if (turn % 2 != 0) std::swap(half.x(), half.y());
    extent = (half - found.shape.size).cwiseAbs().maxCoeff();
  }
  errors.max_yaw = std::max(errors.max_yaw, best);
  errors.max_half_extent = std::max(errors.max_half_extent, extent);
}

/// Errors over `scenes` scenes of the objects of one type.
Errors measure(int scenes, int obstacles, double noise, ShapeType type, double displacement = 0) {
  Errors errors;
  for (int i = 0; i < scenes; ++i) {
    auto scenario = scene_of(static_cast<std::uint64_t>(i), obstacles, noise);
    if (displacement > 0) {
      const auto displaced = scene::displace(scenario, displacement, 77, static_cast<std::uint64_t>(i));
      EXPECT_TRUE(displaced.ok());
      if (displaced.ok()) scenario = displaced->scenario;
    }
    auto clouds = render_depth(scenario);
    EXPECT_TRUE(clouds.ok());
    if (!clouds.ok()) break;
    const auto estimate = scene::perceive(scene::perception_request(scenario, std::move(*clouds)));
    EXPECT_TRUE(estimate.ok());
    if (!estimate.ok()) break;
    EXPECT_EQ(estimate->scene, scene::scene_id(scenario));
    const Vector3d table = estimate->table.top_centre - scenario.table.top_centre;
    errors.max_table_height = std::max(errors.max_table_height, std::abs(table.z()));
    errors.max_table_size =
        std::max(errors.max_table_size, (estimate->table.size - scenario.table.size).cwiseAbs().maxCoeff());
    for (const auto& object : scenario.objects) {
      if (object.type != type) continue;
      ++errors.objects;
      const auto* found = estimate->object(object.name);
      errors.missing += !found;
      errors.wrong_type += found && found->type != object.type;
      if (!found || found->type != object.type) continue;
      const double distance = (found->X_WO.translation() - object.position).norm();
      errors.max_position = std::max(errors.max_position, distance);
      errors.sum_position += distance;
      if (type == ShapeType::cylinder) {
        compare_cylinder(object, *found, errors);
      } else {
        compare_box(object, *found, errors);
      }
    }
  }
  return errors;
}

void print(const std::string& what, const Errors& e) {
  std::cout << "[ measured ] " << what << ": " << e.objects << " objects, position max " << 1e3 * e.max_position
            << " mm, mean " << 1e3 * e.sum_position / std::max(e.objects, 1) << " mm, radius max " << 1e3 * e.max_radius
            << " mm, height max " << 1e3 * e.max_height << " mm, half extents max " << 1e3 * e.max_half_extent
            << " mm, yaw max " << e.max_yaw << " rad, table height max " << 1e3 * e.max_table_height
            << " mm, table size max " << 1e3 * e.max_table_size << " mm, missing " << e.missing << ", wrong type "
            << e.wrong_type << "\n";
}

TEST(PerceptionAccuracy, unoccluded_cylinders_are_found_within_five_millimetres) {
  for (const double noise : {0.0, 0.002}) {
    const Errors errors = measure(100, 0, noise, ShapeType::cylinder);
    print(noise > 0 ? "cylinders alone, 2 mm noise" : "cylinders alone, no noise", errors);
    EXPECT_EQ(errors.objects, 100);
    EXPECT_EQ(errors.missing + errors.wrong_type, 0);
    EXPECT_LT(errors.max_position, 0.005);
    EXPECT_LT(errors.max_radius, 0.002);
    EXPECT_LT(errors.max_height, 0.003);
    EXPECT_LT(errors.max_table_height, 0.001);
    EXPECT_LT(errors.max_table_size, 0.01);
  }
}

TEST(PerceptionAccuracy, cylinders_in_clutter_are_found_within_five_millimetres) {
  const Errors errors = measure(60, 3, 0.002, ShapeType::cylinder);
  print("cylinders in clutter, 2 mm noise", errors);
  EXPECT_EQ(errors.missing + errors.wrong_type, 0);
  EXPECT_LT(errors.max_position, 0.005);
  EXPECT_LT(errors.max_radius, 0.003);
}

TEST(PerceptionAccuracy, objects_nearly_touching_after_displacement_are_told_apart) {
  const Errors errors = measure(60, 3, 0.002, ShapeType::cylinder, 0.05);
  print("cylinders displaced by up to 5 cm, 2 mm noise", errors);
  EXPECT_LE(errors.missing + errors.wrong_type, errors.objects / 50);
  EXPECT_LT(errors.max_position, 0.005);
}

TEST(PerceptionAccuracy, boxes_are_found_with_their_extents_and_heading) {
  const Errors errors = measure(60, 2, 0.002, ShapeType::box);
  print("boxes in clutter, 2 mm noise", errors);
  EXPECT_GT(errors.objects, 20);
  EXPECT_EQ(errors.missing + errors.wrong_type, 0);
  EXPECT_LT(errors.max_position, 0.005);
  EXPECT_LT(errors.max_half_extent, 0.006);
  EXPECT_LT(errors.max_yaw, 0.1);
}

TEST(PerceptionAccuracy, the_same_clouds_give_the_same_bytes) {
  const auto scenario = scene_of(5, 3, 0.002);
  const auto clouds = render_depth(scenario);
  ASSERT_TRUE(clouds.ok());
  const auto request = scene::perception_request(scenario, *clouds);
  const auto first = scene::perceive(request), second = scene::perceive(request);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first->octree, second->octree);
  ASSERT_EQ(first->objects.size(), second->objects.size());
  for (std::size_t i = 0; i < first->objects.size(); ++i) {
    const auto& a = first->objects[i];
    const auto& b = second->objects[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(std::memcmp(a.X_WO.data(), b.X_WO.data(), 16 * sizeof(double)), 0);
    EXPECT_EQ(std::memcmp(a.shape.size.data(), b.shape.size.data(), 3 * sizeof(double)), 0);
    EXPECT_EQ(a.points, b.points);
  }
}

}  // namespace
}  // namespace primo::physics

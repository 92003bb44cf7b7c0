#include "physics/picture.h"

#include <gtest/gtest.h>

#include "core/files.h"
#include "grasp_fixture.h"
#include "physics/renderer.h"
#include "place_fixture.h"

namespace primo::physics {
namespace {

namespace fs = std::filesystem;

fs::path scratch(const std::string& name) { return fs::path(::testing::TempDir()) / ("primo_picture_" + name); }

TEST(Picture, is_a_png_file_of_the_wanted_size_and_the_same_every_time) {
  const auto robot = testing::load_robot();
  const auto scenario = testing::one_cylinder();
  PictureOptions options;
  options.width = 96;
  options.height = 64;
  const auto a = scratch("a.png"), b = scratch("b.png");
  ASSERT_TRUE(render_png(a, &robot, scenario, robot.home(), options).ok());
  ASSERT_TRUE(render_png(b, &robot, scenario, robot.home(), options).ok());
  const std::string bytes = *read_file(a);
  ASSERT_GT(bytes.size(), 100u);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  EXPECT_EQ(static_cast<unsigned char>(bytes[19]), 96);  // IHDR: width, height, big-endian
  EXPECT_EQ(static_cast<unsigned char>(bytes[23]), 64);
  EXPECT_EQ(bytes, *read_file(b));
  fs::remove(a);
  fs::remove(b);
}

TEST(Picture, shows_the_robot_and_the_motion) {
  const auto robot = testing::load_robot();
  const auto scenario = testing::one_cylinder();
  MotionPictureOptions options;
  options.picture.width = 96;
  options.picture.height = 64;
  const auto still = scratch("still.png"), motion = scratch("motion.png"), empty = scratch("empty.png");
  PictureOptions view = options.picture;
  view.view = overview(scenario);
  Eigen::MatrixXd q(3, robot.joints());
  for (int t = 0; t < 3; ++t) q.row(t) = robot.home().transpose();
  q(0, 1) += 0.8;
  q(1, 1) += 0.4;
  ASSERT_TRUE(render_png(still, &robot, scenario, robot.home(), view).ok());
  ASSERT_TRUE(render_png(empty, nullptr, scenario, {}, view).ok());
  ASSERT_TRUE(render_motion_png(motion, robot, scenario, q, options).ok());
  EXPECT_NE(*read_file(still), *read_file(empty));
  EXPECT_NE(*read_file(still), *read_file(motion));
  for (const auto& path : {still, motion, empty}) fs::remove(path);
}

TEST(Picture, shows_a_held_object_where_the_hand_carries_it) {
  // With or without the object where the motion begins and ends, the pictures differ there: a motion of the hand alone
  // that is drawn with the object left behind would look the same whatever X_GO is.
  const auto robot = testing::load_robot();
  const auto request = testing::place_at(robot, {0, 0, 0});
  ASSERT_TRUE(request.has_value());
  scene::Scenario elsewhere = request->scenario;
  elsewhere.held->position += Eigen::Vector3d(0, 0.05, 0);
  MotionPictureOptions options;
  options.picture.width = 96;
  options.picture.height = 64;
  const auto a = scratch("held.png"), b = scratch("elsewhere.png");
  ASSERT_TRUE(render_motion_png(a, robot, request->scenario, request->q, options).ok());
  ASSERT_TRUE(render_motion_png(b, robot, elsewhere, request->q, options).ok());
  EXPECT_NE(*read_file(a), *read_file(b));
  for (const auto& path : {a, b}) fs::remove(path);
}

TEST(Picture, shows_another_motions_path_dashed_and_in_another_colour) {
  const auto robot = testing::load_robot();
  const auto scenario = testing::one_cylinder();
  MotionPictureOptions options;
  options.picture.width = 160;
  options.picture.height = 120;
  Eigen::MatrixXd q(9, robot.joints()), other(9, robot.joints());
  for (int t = 0; t < 9; ++t) {
    q.row(t) = other.row(t) = robot.home().transpose();
    q(t, 1) += 0.05 * t;
    other(t, 0) += 0.1 * t;
  }
  const auto alone = scratch("alone.png"), compared = scratch("compared.png");
  ASSERT_TRUE(render_motion_png(alone, robot, scenario, q, options).ok());
  options.compare = &other;
  ASSERT_TRUE(render_motion_png(compared, robot, scenario, q, options).ok());
  EXPECT_NE(*read_file(alone), *read_file(compared));
  other.conservativeResize(9, 3);
  EXPECT_FALSE(render_motion_png(compared, robot, scenario, q, options).ok());
  for (const auto& path : {alone, compared}) fs::remove(path);
}

TEST(Picture, refuses_wrong_sizes_and_joint_counts_with_a_sentence) {
  const auto robot = testing::load_robot();
  const auto scenario = testing::one_cylinder();
  PictureOptions options;
  options.width = 5;
  EXPECT_FALSE(render_png(scratch("x.png"), &robot, scenario, robot.home(), options).ok());
  const auto status = render_png(scratch("x.png"), &robot, scenario, Eigen::VectorXd::Zero(3));
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("14"), std::string::npos);
  EXPECT_FALSE(fs::exists(scratch("x.png")));
  EXPECT_FALSE(render_png("/nonexistent/folder/x.png", &robot, scenario, robot.home()).ok());
}

TEST(Shrink, takes_the_mean_of_each_block) {
  Image image{4, 2, std::vector<unsigned char>(24, 0)};
  for (int channel = 0; channel < 3; ++channel) {
    image.rgb[static_cast<std::size_t>(channel)] = 100;         // pixel (0, 0)
    image.rgb[static_cast<std::size_t>(3 * 5 + channel)] = 60;  // pixel (1, 1)
    image.rgb[static_cast<std::size_t>(3 * 7 + channel)] = 8;   // pixel (3, 1)
  }
  const Image small = shrink(image, 2);
  ASSERT_EQ(small.rgb.size(), 6u);
  EXPECT_EQ(small.rgb[0], 40);
  EXPECT_EQ(small.rgb[3], 2);
}

}  // namespace
}  // namespace primo::physics

#include "physics/model.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "core/random.h"
#include "grasp_fixture.h"

namespace primo::physics {
namespace {

TEST(Assemble, puts_every_object_where_the_scenario_has_it) {
  const auto robot = testing::load_robot();
  auto scenario = testing::one_cylinder();
  scene::Object box;
  box.name = "a <strange> \"name\" & more";
  box.type = ShapeType::box;
  box.position = {0.7, 0.1, 0.72};
  box.rpy = {0, 0, 0.4};
  scenario.objects.push_back(box);
  const auto model = assemble(&robot, scenario);
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  mj_forward(model->get(), data.get());
  for (const auto& object : scenario.objects) {
    const int body = model->body(object.name), geom = model->geom("object:" + object.name);
    ASSERT_GE(body, 0) << object.name;
    ASSERT_GE(geom, 0) << object.name;
    EXPECT_TRUE(body_pose(data.get(), body).isApprox(object.X_WO(), 1e-12));
    EXPECT_EQ((*model)->geom_group[geom], kObjectGroup);
    EXPECT_NEAR((*model)->body_mass[body], object.mass, 1e-12);
  }
  EXPECT_GE(model->geom("table"), 0);
}

TEST(Assemble, objects_stay_where_they_stand) {
  const auto model = assemble(nullptr, testing::one_cylinder());
  ASSERT_TRUE(model.ok());
  Data data(*model);
  for (int k = 0; k < 1000; ++k) mj_step(model->get(), data.get());
  const Eigen::Vector3d p = body_pose(data.get(), model->body("c1")).translation();
  EXPECT_LT((p - Eigen::Vector3d(0.8, 0, 0.724)).norm(), 1e-3);
  EXPECT_FALSE(diverged(data.get()));
}

TEST(Assemble, boxes_stay_where_they_stand_whatever_their_size_and_heading) {
  // Faces that lie in each other are where MuJoCo 2.2 finds contacts that are not there: in one box of eight within 6
  // s.
  Random random(1, "boxes on a table");
  auto scenario = testing::one_cylinder();
  scene::Object& box = scenario.objects[0];
  box.type = ShapeType::box;
  for (int i = 0; i < 60; ++i) {
    box.half_extents = {random.uniform(0.025, 0.045), random.uniform(0.025, 0.045), random.uniform(0.04, 0.07)};
    box.position = {random.uniform(0.7, 0.9), random.uniform(-0.14, 0.14), 0.67 + box.half_extents.z()};
    box.rpy.z() = random.uniform(-1.5, 1.5);
    const auto model = assemble(nullptr, scenario);
    ASSERT_TRUE(model.ok()) << model.error().message;
    Data data(*model);
    for (int k = 0; k < 3000; ++k) mj_step(model->get(), data.get());
    EXPECT_TRUE(body_pose(data.get(), model->body("c1")).isApprox(box.X_WO(), 2e-4))
        << "box " << i << " is at " << body_pose(data.get(), model->body("c1")).translation().transpose();
  }
}

TEST(Assemble, names_taken_twice_and_numbers_that_are_not_finite_are_errors) {
  const auto robot = testing::load_robot();
  auto scenario = testing::one_cylinder();
  scenario.objects[0].name = "palm";
  auto model = assemble(&robot, scenario);
  ASSERT_FALSE(model.ok());
  EXPECT_NE(model.error().message.find("palm"), std::string::npos);
  scenario = testing::one_cylinder();
  scenario.objects[0].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(assemble(&robot, scenario).ok());
}

TEST(Compile, says_what_mujoco_refuses_and_where) {
  const auto model = compile("<mujoco><worldbody><geom size=\"-1\"/></worldbody></mujoco>", {}, "robot somewhere.xml");
  ASSERT_FALSE(model.ok());
  EXPECT_EQ(model.error().code, Code::config);
  EXPECT_EQ(model.error().message.find("robot somewhere.xml: "), 0u);
}

TEST(Diverged, is_told_by_bad_numbers) {
  const auto model = assemble(nullptr, testing::one_cylinder());
  ASSERT_TRUE(model.ok());
  Data data(*model);
  mj_step(model->get(), data.get());
  EXPECT_FALSE(diverged(data.get()));
  data->qvel[0] = std::numeric_limits<double>::quiet_NaN();
  mj_step(model->get(), data.get());
  EXPECT_TRUE(diverged(data.get()));
}

TEST(Pin, HoldsABodyAgainstWhatWouldMoveItAndLetsItGoAsItWas) {
  // p = ½ (F/m) t²: a push of 50 N for 0.1 s moves 0.3 kg by 0.83 m, a building by 2.5 µm.
  auto model = compile(
      "<mujoco><option timestep=\"0.001\" gravity=\"0 0 0\"/><worldbody><body name=\"c\"><freejoint "
      "name=\"c\"/><geom type=\"cylinder\" size=\".0375 .054\" mass=\".3\"/></body></worldbody></mujoco>",
      {}, "pin");
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  const Pin pin(*model, model->joint("c"));
  const auto pushed = [&] {
    mj_resetData(model->get(), data.get());
    data->xfrc_applied[6] = 50;
    for (int k = 0; k < 3000; ++k) mj_step(model->get(), data.get());
    return data->qpos[0];
  };
  const double before = pushed();
  EXPECT_NEAR(before, 0.5 * 50 / 0.3 * 0.01, 0.02 * before);
  pin.hold(model->get(), data.get());
  EXPECT_LT(pushed(), 5e-6);
  pin.release(model->get(), data.get());
  EXPECT_EQ(pushed(), before);
}

}  // namespace
}  // namespace primo::physics

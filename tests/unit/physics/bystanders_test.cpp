// What makes steps cheaper must not change what happens: objects left alone until they are touched, pairs of shapes
// that are not examined.
#include "physics/bystanders.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "grasp_fixture.h"
#include "physics/contact_filter.h"

namespace primo::physics {
namespace {

/// c1, which the action is about, and a cylinder and a box beside it.
scene::Scenario with_two_neighbours() {
  auto scenario = testing::one_cylinder();
  scene::Object cylinder = scenario.objects[0];
  cylinder.name = "o1";
  cylinder.position.x() += 0.1;
  scene::Object box;
  box.name = "o2";
  box.type = ShapeType::box;
  box.half_extents = {0.03, 0.03, 0.05};
  box.position = {0.7, 0.15, 0.72};
  scenario.objects.push_back(cylinder);
  scenario.objects.push_back(box);
  return scenario;
}

TEST(Bystanders, stay_to_the_bit_until_touched_and_fall_like_others_when_they_are) {
  const auto scenario = with_two_neighbours();
  auto model = assemble(nullptr, scenario);
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  Bystanders bystanders(*model, scenario);
  bystanders.rest(model->get(), data.get());
  EXPECT_EQ(bystanders.resting(), 2);
  const int c1 = (*model)->jnt_qposadr[model->joint("c1")], velocity = (*model)->jnt_dofadr[model->joint("c1")];
  const auto step = [&](int count) {
    for (int k = 0; k < count; ++k) {
      mj_step1(model->get(), data.get());
      bystanders.wake_touched(model->get(), data.get());
      mj_step2(model->get(), data.get());
    }
  };
  step(500);
  for (const char* name : {"o1", "o2"}) {
    const Eigen::Vector3d at = body_pose(data.get(), model->body(name)).translation();
    EXPECT_LT((at - scenario.object(name)->position).norm(), 1e-12) << name;
  }
  EXPECT_LT((body_pose(data.get(), model->body("c1")).translation() - scenario.objects[0].position).norm(), 1e-3);
  // c1 thrown against o1 from 25 mm away, at a speed that topples it: 1.5 m/s against the 1.0 m/s that lift the centre
  // of mass by the 12 mm to the edge for two bodies that share the momentum.
  data->qvel[velocity] = 3;
  data->qpos[c1 + 2] += 0.03;
  step(500);
  EXPECT_EQ(bystanders.resting(), 1);
  EXPECT_LT(body_pose(data.get(), model->body("o1")).linear()(2, 2), 0.5) << "it lies";
  EXPECT_LT((body_pose(data.get(), model->body("o2")).translation() - scenario.object("o2")->position).norm(), 1e-12);
  EXPECT_GT(data->xpos[3 * model->body("o1") + 2], 0) << "on the table or the floor";
  EXPECT_EQ(data->xfrc_applied[6 * model->body("o1") + 2], 0) << "it has its weight back";
}

TEST(ContactFilter, leaves_out_no_pair_that_touches) {
  // MuJoCo's own collision detection is the reference: shapes at random, near enough that one pair in three touches.
  constexpr int kShapes = 12;
  const std::vector<std::string> shapes = {"type=\"sphere\" size=\".04\"", "type=\"capsule\" size=\".02 .05\"",
                                           "type=\"cylinder\" size=\".03 .05\"", "type=\"box\" size=\".02 .03 .06\""};
  std::string mjcf = "<mujoco><size njmax=\"3000\" nconmax=\"1000\"/><worldbody><geom type=\"plane\" size=\"1 1 1\"/>";
  for (int i = 0; i < kShapes; ++i) {
    mjcf += "<body><freejoint/><geom margin=\"" + std::string(i % 2 ? "0.002" : "0") + "\" " +
            shapes[static_cast<std::size_t>(i) % shapes.size()] + "/></body>";
  }
  auto model = compile(mjcf + "</worldbody></mujoco>", {}, "shapes");
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  Random random(3, "shapes");
  int apart = 0, touching = 0;
  for (int trial = 0; trial < 200; ++trial) {
    for (int i = 0; i < kShapes; ++i) {
      double* q = data->qpos + 7 * i;
      for (int k = 0; k < 3; ++k) q[k] = random.uniform(0, 0.3);
      for (int k = 3; k < 7; ++k) q[k] = random.normal();
      mju_normalize4(q + 3);
    }
    const auto filter = mjcb_contactfilter;
    ASSERT_NE(filter, nullptr);
    mjcb_contactfilter = nullptr;
    mj_fwdPosition(model->get(), data.get());
    mjcb_contactfilter = filter;
    std::vector<std::pair<int, int>> pairs;
    for (int c = 0; c < data->ncon; ++c) {
      const auto& contact = data->contact[c];
      ++touching;
      EXPECT_FALSE(surely_apart(model->get(), data.get(), contact.geom1, contact.geom2))
          << contact.geom1 << " and " << contact.geom2 << " in trial " << trial;
    }
    for (int a = 1; a <= kShapes; ++a) {
      for (int b = 1; b < a; ++b) apart += surely_apart(model->get(), data.get(), a, b) ? 1 : 0;
    }
    const int all = data->ncon;
    mj_fwdPosition(model->get(), data.get());
    EXPECT_EQ(data->ncon, all);
  }
  EXPECT_GT(touching, 1000);
  EXPECT_GT(apart, 200 * kShapes * (kShapes - 1) / 4) << "more than half of the pairs are told apart";
}

}  // namespace
}  // namespace primo::physics

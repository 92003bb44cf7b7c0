#include "study/codec.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/random.h"
#include "study/rollout.h"
#include "synthetic.h"

namespace primo::study {
namespace {

/// Any finite double, by its bits.
double any_double(Random& random) {
  while (true) {
    const double value = std::bit_cast<double>(random.bits());
    if (std::isfinite(value)) return value;
  }
}

RolloutResult any_result(Random& random) {
  RolloutResult result = test::perfect_grasp();
  result.plan_status = static_cast<motion::PlanStatus>(random.below(7));
  result.plan_reason = "the \"reason\" — ρ\n";
  result.iterations = static_cast<int>(random.below(1000));
  result.plan_cost = any_double(random);
  auto& v = result.verdict;
  for (double* value : {&v.score, &v.displacement, &v.survival, &v.position_error, &v.clearance, &v.target_clearance,
                        &v.limit_margin, &v.max_speed, &v.path_length}) {
    *value = any_double(random);
  }
  v.outcome = static_cast<physics::Outcome>(random.below(9));
  v.criteria = {{"clearance", any_double(random), any_double(random), random.below(2) == 1}};
  v.steps = static_cast<int>(random.below(5000));
  v.survivals = {{any_double(random), 7, static_cast<int>(random.below(8)), any_double(random), any_double(random)}};
  v.contacts = {{"palm", "c1", any_double(random), any_double(random), any_double(random)}};
  v.unlisted_contacts = static_cast<int>(random.below(9));
  return result;
}

TEST(Codec, rollout_results_read_back_to_the_same_bits) {
  Random random(1, "codec");
  for (int i = 0; i < 500; ++i) {
    const auto result = any_result(random);
    const auto text = encode(result);
    const auto back = decode_rollout_result(text);
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(encode(*back), text);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back->verdict.clearance),
              std::bit_cast<std::uint64_t>(result.verdict.clearance));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back->plan_cost), std::bit_cast<std::uint64_t>(result.plan_cost));
    ASSERT_EQ(back->verdict.before, result.verdict.before);
    ASSERT_EQ(back->plan_status, result.plan_status);
    ASSERT_EQ(back->verdict.contacts.at(0).peak_force, result.verdict.contacts[0].peak_force);
    ASSERT_EQ(back->verdict.survivals.at(0).held, result.verdict.survivals[0].held);
  }
}

TEST(Codec, keeps_numbers_that_json_has_no_word_for) {
  RolloutResult result = test::perfect_grasp();
  result.verdict.clearance = std::numeric_limits<double>::infinity();
  result.verdict.score = -0.0;
  const auto back = decode_rollout_result(encode(result));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->verdict.clearance, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::signbit(back->verdict.score));
}

TEST(Codec, scene_estimates_read_back_to_the_same_bits) {
  Random random(2, "codec");
  for (int i = 0; i < 100; ++i) {
    auto estimate = test::estimate(test::scenario("s"));
    estimate.objects[0].X_WO = pose({random.normal(), random.normal(), random.normal()},
                                    Eigen::Vector3d{random.normal(), random.normal(), random.normal()});
    estimate.table.thickness = any_double(random);
    const auto back = decode_estimate(encode(estimate));
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(back->objects[0].X_WO.matrix(), estimate.objects[0].X_WO.matrix());
    ASSERT_EQ(back->table.thickness, estimate.table.thickness);
    ASSERT_EQ(back->objects[0].name, "c1");
  }
}

TEST(Codec, refuses_text_that_is_cut_or_changed_with_an_error_and_never_crashes) {
  const std::string text = encode(test::perfect_grasp());
  for (std::size_t n = 0; n < text.size(); n += 7) {
    const auto cut = decode_rollout_result(text.substr(0, n));
    ASSERT_FALSE(cut.ok()) << n;
    ASSERT_EQ(cut.error().code, Code::data);
  }
  Random random(3, "mutations");
  for (int i = 0; i < 3000; ++i) {
    std::string mutated = text;
    for (int k = 0; k < 3; ++k) mutated[random.below(mutated.size())] = static_cast<char>(random.below(256));
    const auto back = decode_rollout_result(mutated);
    if (!back.ok()) {
      ASSERT_EQ(back.error().code, Code::data);
    }
  }
}

TEST(Codec, names_the_field_that_is_wrong) {
  std::string text = encode(test::perfect_grasp());
  text.replace(text.find("\"held\""), 6, "\"holt\"");
  const auto back = decode_rollout_result(text);
  ASSERT_FALSE(back.ok());
  EXPECT_NE(back.error().message.find("outcome"), std::string::npos) << back.error().message;
  EXPECT_NE(back.error().message.find("holt"), std::string::npos);
}

Rollout base_rollout() {
  Rollout rollout;
  rollout.scenario = test::scenario("s");
  rollout.estimate = test::estimate(rollout.scenario);
  rollout.primitive = test::primitive(3);
  return rollout;
}

TEST(Keys, differ_when_anything_in_the_request_differs) {
  const auto base = base_rollout();
  std::set<std::string> keys = {key_of(base)};
  int changes = 0;
  const auto expect_new = [&](auto change) {
    Rollout rollout = base;
    change(rollout);
    ++changes;
    EXPECT_TRUE(keys.insert(key_of(rollout)).second) << "change " << changes;
  };
  expect_new([](Rollout& r) { r.judge_seed = 1; });
  expect_new([](Rollout& r) { r.mode = physics::Mode::execute; });
  expect_new([](Rollout& r) { r.judge.jiggle_frequency += 1e-15; });
  expect_new([](Rollout& r) { r.primitive.tasks[1].rho = std::nextafter(1.0, 2.0); });
  expect_new([](Rollout& r) { r.primitive.tasks[1].parameters["margin"] = 0; });
  expect_new([](Rollout& r) { r.primitive.solver = "aico"; });
  expect_new([](Rollout& r) { r.scenario.objects[0].position.y() = 1e-300; });
  expect_new([](Rollout& r) { r.scenario.action[1] = "c2"; });
  expect_new([](Rollout& r) { r.scenario.robot_start = {0}; });
  expect_new([](Rollout& r) { r.scenario.held = scene::Held{"c1"}; });
  expect_new([](Rollout& r) { r.scenario.held = scene::Held{"c1", {0, 0, 1e-12}}; });
  expect_new([](Rollout& r) { r.estimate.objects[0].X_WO.translation().z() += 1e-12; });
  expect_new([](Rollout& r) { r.estimate.objects.clear(); });
  expect_new([](Rollout& r) { r.estimate.table.top_centre.x() += 1e-12; });
  EXPECT_EQ(key_of(base), key_of(base_rollout()));
}

TEST(Keys, do_not_depend_on_where_the_study_lies) {
  OptimizeGoal goal;
  goal.primitive = test::primitive(2);
  goal.directory = "/a";
  const auto key = key_of(goal);
  goal.directory = "/b";
  EXPECT_EQ(key_of(goal), key);
  goal.round = 1;
  EXPECT_NE(key_of(goal), key);
}

}  // namespace
}  // namespace primo::study

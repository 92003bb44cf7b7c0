#include "study/fitness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "synthetic.h"

namespace primo::study {
namespace {

using symbols::Literal;

TEST(Fitness, is_greatest_where_nothing_is_lost) {
  const auto perfect = test::perfect_grasp();
  const FitnessSettings settings;
  for (const Signal kind : {Signal::mixed, Signal::graded, Signal::binary}) {
    EXPECT_DOUBLE_EQ(signal(perfect, true, kind, settings), best_signal(kind, settings));
  }
}

TEST(Fitness, of_a_perfect_grasp_is_the_sum_of_the_positive_weights) {
  EXPECT_DOUBLE_EQ(trajectory_fitness(test::perfect_grasp(), true, {}), 0.5 + 0.5 + 0.25 + 0.25 + 0.1);
}

TEST(Fitness, adds_the_terms_of_its_definition) {
  RolloutResult result = test::perfect_grasp();
  result.iterations = 40;
  auto& v = result.verdict;
  v.success = false;
  v.outcome = physics::Outcome::fell_in_jiggle;
  v.score = 0.6;
  v.clearance = 0.005;          // ¾ of the way from −1 cm to 1 cm
  v.target_clearance = -0.013;  // half way from −2 cm to −6 mm
  v.limit_margin = -0.01;
  v.max_speed = 2.5;
  v.path_length = 3;
  // Four fifths of the score count only as far as the path is clean.
  const double clean = 0.75 * 0.5, score = 0.6 * (0.2 + 0.8 * clean);
  const double expected = 0.5 * score + 0.25 * 0.75 + 0.25 * 0.5 - 0.1 * 1.0 - 0.02 * 3 - 0.1 * 40 / 100.0;
  EXPECT_NEAR(trajectory_fitness(result, false, {}), expected, 1e-12);
}

TEST(Fitness, takes_the_limits_from_the_judges_criterion) {
  RolloutResult result = test::perfect_grasp();
  result.verdict.limit_margin = 0.02;
  result.verdict.criteria = {{"limit_margin", 0.02, 0.05, false}};
  EXPECT_DOUBLE_EQ(trajectory_fitness(result, true, {}), 1.5);
}

TEST(Fitness, is_monotone_in_every_margin) {
  const auto g = [](auto change) {
    RolloutResult result = test::perfect_grasp();
    change(result);
    return trajectory_fitness(result, false, {});
  };
  double last = -1e9;
  for (double d = -0.05; d < 0.05; d += 0.001) {
    const double now = g([&](RolloutResult& r) { r.verdict.clearance = r.verdict.target_clearance = d; });
    EXPECT_GE(now, last);
    last = now;
  }
  last = 1e9;
  for (double x = 0; x < 20; x += 0.1) {
    const double now = g([&](RolloutResult& r) {
      r.verdict.max_speed = r.verdict.path_length = x;
      r.iterations = static_cast<int>(10 * x);
    });
    EXPECT_LE(now, last);
    last = now;
  }
}

TEST(Fitness, is_finite_and_bounded_below_whatever_the_verdict_holds) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(),
                        1e300,
                        -1e300,
                        0};
  Random random(1, "verdicts");
  for (int i = 0; i < 2000; ++i) {
    RolloutResult result = test::perfect_grasp();
    auto& v = result.verdict;
    for (double* value : {&v.score, &v.clearance, &v.target_clearance, &v.limit_margin, &v.max_speed, &v.path_length,
                          &v.position_error}) {
      *value = bad[random.below(6)];
    }
    v.outcome = static_cast<physics::Outcome>(random.below(9));
    result.iterations = static_cast<int>(random.below(101));
    const double g = trajectory_fitness(result, false, {});
    ASSERT_TRUE(std::isfinite(g));
    ASSERT_GE(g, worst_fitness({}, 100));
    ASSERT_LE(g, 1.1);
  }
}

TEST(Fitness, a_score_behind_an_unclean_path_and_clearance_far_away_can_be_made_to_count_less) {
  RolloutResult result = test::perfect_grasp();
  auto& v = result.verdict;
  v.score = 1;
  v.clearance = -0.02;  // below clearance_from: not clean at all
  v.target_clearance = 0;
  v.position_error = 0.2;
  FitnessSettings separate;
  separate.clean_share = separate.near = 0;
  FitnessSettings clean = separate, near = separate;
  clean.clean_share = 0.8;
  near.near = 0.1;
  const double g = trajectory_fitness(result, false, separate);
  // 0.8 of the score's weight is lost; of the target's clearance, e⁻² remains.
  EXPECT_NEAR(trajectory_fitness(result, false, clean), g - 0.8 * separate.score, 1e-12);
  EXPECT_NEAR(trajectory_fitness(result, false, near), g - separate.target_clearance * (1 - std::exp(-2.0)), 1e-12);
  v.clearance = 0.05;
  EXPECT_NEAR(trajectory_fitness(result, false, clean), trajectory_fitness(result, false, separate), 1e-12);
}

TEST(Fitness, of_an_unjudged_plan_is_never_above_zero) {
  RolloutResult result = test::perfect_grasp();
  for (const auto outcome : {physics::Outcome::bad_plan, physics::Outcome::unstable}) {
    result.verdict.outcome = outcome;
    EXPECT_LE(trajectory_fitness(result, false, {}), 0);
  }
}

TEST(Fitness, is_the_mean_over_the_scenarios) {
  const std::vector<double> g = {1.0, 0.25, -0.5, 0.25};
  EXPECT_DOUBLE_EQ(fitness(g), 0.25);
}

TEST(Desired, binds_the_actions_arguments_and_deictic_variables) {
  const auto verdict = test::perfect_grasp().verdict;
  const std::vector<std::string> action = {"grasp", "c1"};
  EXPECT_TRUE(holds_desired(verdict, test::grasped(), action));
  EXPECT_TRUE(holds_desired(verdict, {{"inhand", {"c1"}}}, action)) << "ground";
  EXPECT_FALSE(holds_desired(verdict, {{"inhand", {"X"}}}, {"grasp", "c2"}));
  EXPECT_FALSE(holds_desired(verdict, {{"inhand", {"X"}, true}}, action));
  EXPECT_TRUE(holds_desired(verdict, {{"inhand", {"Y"}}}, action)) << "some object is in the hand";
}

TEST(Desired, a_negated_deictic_literal_must_have_held_before_and_ceased_for_all) {
  auto verdict = test::perfect_grasp().verdict;
  const std::vector<std::string> action = {"grasp", "c1"};
  const std::vector<Literal> off = {{"on", {"X", "Y"}, true}};
  EXPECT_TRUE(holds_desired(verdict, off, action));
  verdict.after.insert({"on", {"c1", "c7"}});
  EXPECT_TRUE(holds_desired(verdict, off, action)) << "only what held before is meant";
  verdict.before.insert({"on", {"c1", "c7"}});
  EXPECT_FALSE(holds_desired(verdict, off, action));
  verdict.before.clear();
  EXPECT_FALSE(holds_desired(verdict, off, action)) << "nothing changed";
}

TEST(Desired, success_needs_the_strict_verdict_and_the_outcome) {
  RolloutResult result = test::perfect_grasp();
  const std::vector<std::string> action = {"grasp", "c1"};
  EXPECT_TRUE(succeeded(result, test::grasped(), action));
  result.verdict.success = false;
  EXPECT_FALSE(succeeded(result, test::grasped(), action));
  result = test::perfect_grasp();
  result.verdict.after = result.verdict.before;
  EXPECT_FALSE(succeeded(result, test::grasped(), action));
}

TEST(FitnessSettings, refuse_a_ramp_that_does_not_rise) {
  FitnessSettings settings;
  settings.clearance_to = settings.clearance_from;
  const auto status = settings.validate();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("clearance_from"), std::string::npos);
}

}  // namespace
}  // namespace primo::study

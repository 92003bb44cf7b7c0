#include "study/pool.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "study/codec.h"
#include "study/optimization.h"
#include "study/study.h"
#include "synthetic.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

const robot::Robot& robot() {
  static const robot::Robot schunk =
      robot::Robot::load(std::string(PRIMO_SOURCE_DIR) + "/configs/robots/schunk_lwa3_sdh2.yaml").value();
  return schunk;
}

std::vector<scene::Scenario> originals(int count) {
  std::vector<scene::Scenario> all;
  for (int k = 0; k < count; ++k) {
    all.push_back(test::scenario("s" + std::to_string(k), 0.72 + 0.03 * k));
  }
  return all;
}

Eigen::Vector3d moved(const scene::Scenario& copy, const scene::Scenario& original) {
  return copy.objects[0].position - original.objects[0].position;
}

TEST(Pool, copies_each_original_by_amounts_spread_from_none_to_the_greatest) {
  const auto training = originals(3);
  const auto pool = draw_pool(robot(), training, 62, 0.04, 7, "pool");
  ASSERT_TRUE(pool.ok()) << pool.error().message;
  ASSERT_EQ(pool->size(), 62u);
  std::set<std::string> names;
  std::set<std::uint64_t> cameras;
  for (std::size_t i = 0; i < pool->size(); ++i) {
    // 62 = 21 + 21 + 20 copies of the three, in this order.
    const std::size_t original = i < 21 ? 0 : i < 42 ? 1 : 2, copies = original < 2 ? 21 : 20;
    const double share = static_cast<double>(i - original * 21 + 1) / static_cast<double>(copies);
    const Eigen::Vector3d d = moved((*pool)[i], training[original]);
    EXPECT_LE(d.cwiseAbs().maxCoeff(), 0.04 * share) << i;
    EXPECT_NE(d.norm(), 0) << i;
    EXPECT_EQ(d.z(), 0);
    names.insert((*pool)[i].name);
    cameras.insert((*pool)[i].camera_seed);
  }
  EXPECT_EQ(names.size(), 62u);
  EXPECT_EQ(cameras.size(), 62u) << "the cameras' noise differs too";
  const auto again = draw_pool(robot(), training, 62, 0.04, 7, "pool"),
             other = draw_pool(robot(), training, 62, 0.04, 8, "pool");
  EXPECT_EQ(key_of((*again)[40]), key_of((*pool)[40]));
  EXPECT_NE(moved((*other)[40], training[1]), moved((*pool)[40], training[1]));
}

TEST(Pool, a_draw_has_one_of_each_part_and_depends_on_seed_round_and_generation) {
  std::map<std::size_t, int> count;
  std::set<std::vector<std::size_t>> draws;
  for (int generation = 0; generation < 600; ++generation) {
    const auto drawn = draw_from_pool(20, 6, 3, 0, generation);
    ASSERT_EQ(drawn.size(), 6u);
    for (std::size_t part = 0; part < 6; ++part) {
      EXPECT_GE(drawn[part], part * 20 / 6);
      EXPECT_LT(drawn[part], (part + 1) * 20 / 6);
      ++count[drawn[part]];
    }
    draws.insert(drawn);
  }
  EXPECT_EQ(count.size(), 20u) << "all of the pool is used";
  for (const auto& [index, times] : count) {
    const std::size_t part = (index * 6 + 5) / 20;  // parts of 3 or 4: each of a part is drawn equally often
    const double expected = 600.0 / static_cast<double>((part + 1) * 20 / 6 - part * 20 / 6);
    EXPECT_NEAR(times, expected, 5 * std::sqrt(expected)) << index;
  }
  EXPECT_EQ(draw_from_pool(20, 6, 3, 1, 5), draw_from_pool(20, 6, 3, 1, 5));
  EXPECT_NE(draw_from_pool(200, 6, 3, 1, 5), draw_from_pool(200, 6, 3, 0, 5));
  EXPECT_NE(draw_from_pool(200, 6, 3, 1, 5), draw_from_pool(200, 6, 4, 1, 5));
  EXPECT_EQ(draw_from_pool(4, 0, 3, 0, 0), (std::vector<std::size_t>{0, 1, 2, 3}));
  EXPECT_EQ(draw_from_pool(4, 9, 3, 0, 0).size(), 4u);
}

TEST(Pool, seeds_must_differ_and_the_two_that_do_not_are_named) {
  EXPECT_TRUE(check_distinct_seeds({{"seed", 1}, {"pool.seed", 2}}).ok());
  const auto status = check_distinct_seeds({{"seed", 1}, {"pool.seed", 2}, {"tests.seed", 2}});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, Code::config);
  EXPECT_NE(status.error().message.find("'tests.seed' is 2, the same as 'pool.seed'"), std::string::npos)
      << status.error().message;
}

TEST(Pool, a_study_refuses_training_choice_and_experience_of_one_seed) {
  StudySettings settings;
  settings.pool.seed = settings.experience.seed;
  EXPECT_TRUE(settings.validate().ok()) << "the paper's protocol draws no pool";
  settings.protocol = Protocol::robust;
  EXPECT_NE(settings.validate().error().message.find("pool.seed"), std::string::npos);
  settings.pool = {};
  EXPECT_TRUE(settings.validate().ok());
  settings.pool.validation_seed = settings.pool.seed;
  EXPECT_NE(settings.validate().error().message.find("pool.validation_seed"), std::string::npos);
  settings.pool = {};
  settings.seed = settings.pool.validation_seed;
  EXPECT_NE(settings.validate().error().message.find("'seed'"), std::string::npos);
  settings.seed = 1;
  settings.pool.drawn = settings.pool.scenarios + 1;
  EXPECT_NE(settings.validate().error().message.find("pool.drawn"), std::string::npos);
}

class RobustOptimization : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_robust_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    goal.study = "test-0";
    goal.primitive = test::primitive(2);
    goal.scenarios = draw_pool(robot(), originals(3), 30, 0.02, 7, "pool").value();
    const auto choice = draw_pool(robot(), originals(3), 12, 0.02, 8, "choice");
    goal.scenarios.insert(goal.scenarios.end(), choice->begin(), choice->end());
    for (const auto& s : goal.scenarios) goal.estimates.push_back(test::estimate(s));
    goal.drawn = 5;
    goal.held_out = 12;
    goal.desired = test::grasped();
    goal.optimizer.evaluations = 160;
    goal.optimizer.population = 8;
    goal.algorithms = {"cma"};
    goal.seed = 5;
  }
  void TearDown() override { fs::remove_all(directory); }
  Journal journal(const std::string& name = "journal.db") { return Journal::open(directory / name).value(); }
  fs::path directory;
  OptimizeGoal goal;
};

TEST_F(RobustOptimization, candidates_of_a_generation_meet_the_same_scenarios_and_the_choice_is_made_on_others) {
  std::vector<std::pair<std::string, std::uint64_t>> asked;
  test::FunctionEvaluator evaluator([](const Rollout& r) { return test::bowl(r); });
  evaluator.on_rollout = [&](const Rollout& r) { asked.emplace_back(r.scenario.name, r.judge_seed); };
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->success.trials, 12 * 3) << "the scenarios held out, three seeds each";
  EXPECT_EQ(result->success.value(), 1.0);
  const std::size_t training = 160 * 5;
  ASSERT_GT(asked.size(), training);
  std::set<std::vector<std::pair<std::string, std::uint64_t>>> generations;
  std::set<std::string> seen;
  for (std::size_t begin = 0; begin < training; begin += 40) {  // 8 candidates, 5 scenarios
    const std::vector first(asked.begin() + begin, asked.begin() + begin + 5);
    for (std::size_t i = 0; i < 40; ++i) {
      EXPECT_EQ(asked[begin + i], first[i % 5]);
      EXPECT_NE(asked[begin + i].first.find("_pool_"), std::string::npos);
      seen.insert(asked[begin + i].first);
    }
    generations.insert(first);
  }
  EXPECT_EQ(generations.size(), 20u) << "each generation draws anew";
  EXPECT_GT(seen.size(), 20u);
  for (std::size_t i = training; i < asked.size(); ++i)
    EXPECT_NE(asked[i].first.find("_choice_"), std::string::npos) << asked[i].first;
}

TEST_F(RobustOptimization, gives_the_same_bytes_whatever_the_order_of_answers_and_however_often_stopped) {
  test::FunctionEvaluator forward([](const Rollout& r) { return test::bowl(r); });
  auto one = journal("one.db");
  const auto expected = optimize(goal, forward, one);
  ASSERT_TRUE(expected.ok());
  for (int runs = 0; runs < 50; ++runs) {
    auto two = journal("two.db");
    test::FunctionEvaluator backward([](const Rollout& r) { return test::bowl(r); });
    backward.reverse = true;
    backward.fail_after = 131;
    const auto result = optimize(goal, backward, two);
    if (!result.ok()) continue;
    EXPECT_GT(runs, 3);
    EXPECT_EQ(encode(*result), encode(*expected));
    return;
  }
  FAIL() << "never ended";
}

TEST_F(RobustOptimization, stops_early_when_the_candidates_get_no_better_although_some_scenario_always_fails) {
  goal.optimizer.evaluations = 4000;
  OptimizationSettings settings;
  settings.early_stop.generations = 10;
  settings.sensitivity = 0;
  goal.settings = config::dump(settings);
  const auto partly = [](const Rollout& r) {  // nothing succeeds in the third original
    return test::bowl(r, 3.0, r.scenario.name[1] == '2' ? 0.0 : 2.0);
  };
  test::FunctionEvaluator evaluator(partly);
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok());
  EXPECT_LT(result->evaluations, 2000);
  EXPECT_GE(result->evaluations, 2 * 10 * 8) << "two windows at least";
  EXPECT_EQ(result->success.successes, 2 * result->success.trials / 3);
}

TEST_F(RobustOptimization, refuses_a_goal_that_leaves_nothing_to_train_on) {
  test::FunctionEvaluator evaluator([](const Rollout& r) { return test::bowl(r); });
  auto record = journal();
  goal.held_out = static_cast<int>(goal.scenarios.size());
  const auto result = optimize(goal, evaluator, record);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("held_out"), std::string::npos);
  goal.held_out = 0;
  goal.drawn = -1;
  EXPECT_NE(optimize(goal, evaluator, record).error().message.find("drawn"), std::string::npos);
}

TEST(PoolGoal, key_of_the_goal_tells_how_scenarios_are_drawn) {
  OptimizeGoal goal, other;
  other.drawn = 3;
  EXPECT_NE(key_of(goal), key_of(other));
  other = goal;
  other.held_out = 3;
  EXPECT_NE(key_of(goal), key_of(other));
}

}  // namespace
}  // namespace primo::study

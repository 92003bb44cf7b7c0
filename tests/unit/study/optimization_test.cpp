#include "study/optimization.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "study/codec.h"
#include "synthetic.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

class OptimizationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_optimization_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    goal.study = "test-0";
    goal.primitive = test::primitive(3);
    for (int k = 0; k < 4; ++k) {
      goal.scenarios.push_back(test::scenario("s" + std::to_string(k), 0.8 + 0.01 * k));
      goal.estimates.push_back(test::estimate(goal.scenarios.back()));
    }
    goal.desired = test::grasped();
    goal.optimizer.evaluations = 200;
    goal.optimizer.population = 10;
    goal.algorithms = {"cma"};
    goal.seed = 5;
  }
  void TearDown() override { fs::remove_all(directory); }
  Journal journal(const std::string& name = "journal.db") {
    auto opened = Journal::open(directory / name);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(*opened);
  }
  static RolloutResult roll(const Rollout& rollout) { return test::bowl(rollout); }
  /// The bowl's distance in a scenario.
  static double distance(const std::vector<double>& x, const scene::Scenario& s) {
    double square = 0;
    for (const double value : x) square += (value - 3) * (value - 3);
    return std::sqrt(square) + std::abs((s.objects[0].position.x() - 0.8) * 10);
  }
  template <class F>
  void set(F&& change) {
    OptimizationSettings settings;
    change(settings);
    goal.settings = config::dump(settings);
  }

  fs::path directory;
  OptimizeGoal goal;
};

TEST_F(OptimizationTest, cma_finds_precisions_that_succeed_everywhere) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->success.value(), 1.0);
  EXPECT_EQ(result->success.trials, 4 * 3);
  EXPECT_EQ(result->evaluations, 200);
  for (const double x : result->primitive.log_rho()) EXPECT_NEAR(x, 3.0, 0.3);
  EXPECT_EQ(result->primitive.name, "grasp_optimized_1");
}

TEST_F(OptimizationTest, gives_the_same_bytes_whatever_the_order_of_answers) {
  goal.algorithms = {"cma", "monte_carlo"};
  goal.restarts = 2;
  goal.optimizer.evaluations = 60;
  test::FunctionEvaluator forward(roll), backward(roll);
  backward.reverse = true;
  auto one = journal("one.db"), two = journal("two.db");
  const auto a = optimize(goal, forward, one), b = optimize(goal, backward, two);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(encode(*a), encode(*b));
  EXPECT_EQ(a->evaluations, 4 * 60);
}

TEST_F(OptimizationTest, goes_on_after_being_stopped_anywhere_and_ends_with_the_same_bytes) {
  goal.optimizer.evaluations = 60;
  test::FunctionEvaluator undisturbed(roll);
  auto whole = journal("whole.db");
  const auto expected = optimize(goal, undisturbed, whole);
  ASSERT_TRUE(expected.ok());
  int calls = 0, runs = 0;
  while (true) {
    auto record = journal("parts.db");
    test::FunctionEvaluator evaluator(roll);
    evaluator.fail_after = 37;
    const auto result = optimize(goal, evaluator, record);
    calls += evaluator.calls;
    ++runs;
    ASSERT_LT(runs, 100);
    if (!result.ok()) {
      ASSERT_EQ(result.error().code, Code::unavailable);
      continue;
    }
    EXPECT_EQ(encode(*result), encode(*expected));
    EXPECT_EQ(encode(*result), encode(*optimize(goal, evaluator, record)));
    break;
  }
  EXPECT_GT(runs, 5);
  EXPECT_EQ(calls, undisturbed.calls) << "nothing is done twice";
  auto parts = journal("parts.db");
  EXPECT_EQ(parts.evaluations()->size(), whole.evaluations()->size());
}

TEST_F(OptimizationTest, uses_common_random_numbers_within_a_generation_and_fresh_ones_to_choose) {
  goal.optimizer.evaluations = 40;
  std::map<std::string, std::set<std::uint64_t>> seeds;  // by scenario
  std::vector<std::uint64_t> order;
  test::FunctionEvaluator evaluator(roll);
  evaluator.on_rollout = [&](const Rollout& r) {
    seeds[r.scenario.name].insert(r.judge_seed);
    if (r.scenario.name == "s0") order.push_back(r.judge_seed);
  };
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  for (const auto& [name, set] : seeds) EXPECT_EQ(set.size(), 4u + 3u) << "four generations and three validation seeds";
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(order[i], order[i / 10 * 10]);
  std::set<std::uint64_t> all;
  for (const auto& [name, set] : seeds) all.insert(set.begin(), set.end());
  EXPECT_EQ(all.size(), 4u * 7u) << "no two scenarios share a seed";
}

TEST_F(OptimizationTest, keeps_the_primitive_it_began_with_when_nothing_better_is_found) {
  goal.primitive = goal.primitive.with_log_rho({3, 3, 3});
  goal.optimizer.evaluations = 10;
  goal.algorithms = {"monte_carlo"};
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->primitive.name, "test");
  const auto finalists = record.finalists();
  ASSERT_TRUE(finalists.ok());
  int chosen = 0;
  for (const auto& f : *finalists) {
    chosen += f.chosen;
    if (f.chosen) {
      EXPECT_EQ(f.kind, "start");
    }
    EXPECT_LE(f.gamma, result->gamma);
  }
  EXPECT_EQ(chosen, 1);
}

TEST_F(OptimizationTest, stops_early_only_when_told_and_when_the_recommendation_succeeds) {
  goal.optimizer.evaluations = 400;
  OptimizationSettings settings;
  settings.early_stop.generations = 4;
  settings.early_stop.tolerance = 0.02;
  goal.settings = config::dump(settings);
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  std::vector<Progress> seen;
  const auto result = optimize(goal, evaluator, record, [&](const Progress& p) { seen.push_back(p); });
  ASSERT_TRUE(result.ok());
  EXPECT_LT(result->evaluations, 400);
  EXPECT_EQ(result->success.value(), 1.0);
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(seen.back().finished);
  EXPECT_EQ(seen.back().done, result->evaluations);
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_GE(seen[i].best_gamma, seen[i - 1].best_gamma);

  // Nothing ever succeeds: no early end, however flat γ is.
  test::FunctionEvaluator hopeless([](const Rollout& r) { return test::bowl(r, 3.0, 0.0); });
  auto other = journal("other.db");
  goal.optimizer.evaluations = 100;
  const auto none = optimize(goal, hopeless, other);
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->evaluations, 100);
}

TEST_F(OptimizationTest, tells_the_course_of_the_learning_curve) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  const auto course = record.evaluations();
  ASSERT_TRUE(course.ok());
  ASSERT_EQ(course->size(), 200u);
  for (const auto& e : *course) {
    EXPECT_EQ(e.scenarios, 4);
    EXPECT_GE(e.final_pose, e.successes);
    // γ by hand, from the bowl and the settings' defaults.
    double g = 0;
    int successes = 0;
    for (const auto& s : goal.scenarios) {
      const bool success = distance(e.x, s) < 2;
      successes += success;
      g += (0.5 * success + 0.5 / (1 + distance(e.x, s)) + 0.6) / 4;
    }
    EXPECT_EQ(e.successes, successes);
    EXPECT_NEAR(e.gamma, g, 1e-9);
  }
}

TEST_F(OptimizationTest, without_common_random_numbers_every_candidate_has_its_own_seeds) {
  goal.optimizer.evaluations = 40;
  set([](OptimizationSettings& s) {
    s.common_random_numbers = false;
    s.validation = 1;
    s.sensitivity = 0;
  });
  std::map<std::string, std::set<std::uint64_t>> seeds;
  test::FunctionEvaluator evaluator(roll);
  evaluator.on_rollout = [&](const Rollout& r) { seeds[r.scenario.name].insert(r.judge_seed); };
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  for (const auto& [name, set] : seeds) EXPECT_EQ(set.size(), 40u + 1u) << name;
}

TEST_F(OptimizationTest, climbs_success_alone_or_without_it_when_told) {
  goal.optimizer.evaluations = 60;
  for (const auto kind : {Signal::binary, Signal::graded}) {
    set([&](OptimizationSettings& s) { s.signal = kind; });
    test::FunctionEvaluator evaluator(roll);
    auto record = journal(kind == Signal::binary ? "binary.db" : "graded.db");
    ASSERT_TRUE(optimize(goal, evaluator, record).ok());
    const auto course = record.evaluations();
    ASSERT_TRUE(course.ok());
    for (const auto& e : *course) {
      double graded = 0;
      for (const auto& s : goal.scenarios) graded += (0.5 / (1 + distance(e.x, s)) + 0.6) / 4;
      EXPECT_NEAR(e.gamma, kind == Signal::binary ? e.successes / 4.0 : graded, 1e-9);
    }
  }
}

TEST_F(OptimizationTest, evaluates_the_incumbent_anew_on_the_budget_when_told) {
  goal.optimizer.evaluations = 110;
  set([](OptimizationSettings& s) {
    s.reevaluate_incumbent = true;
    s.recommendation = Recommendation::best;
    s.sensitivity = 0;
  });
  std::map<std::vector<double>, int> generations;
  test::FunctionEvaluator evaluator(roll);
  evaluator.on_rollout = [&](const Rollout& r) {
    if (r.scenario.name == "s0") ++generations[r.primitive.log_rho()];
  };
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok()) << result.error().message;
  // Eleven fit: 10 of the first generation, then 11 each; 10 + 9·11 = 109.
  EXPECT_EQ(result->evaluations, 109);
  const auto evaluations = record.evaluations();
  EXPECT_EQ(evaluations->size(), 100u);
  int again = 0;
  for (const auto& [x, times] : generations) again += times > 1;
  EXPECT_GT(again, 0) << "some sample was evaluated more than once";
}

TEST_F(OptimizationTest, recommends_what_it_is_told_to) {
  goal.optimizer.evaluations = 60;
  for (const auto kind : {Recommendation::mean, Recommendation::best, Recommendation::validated}) {
    set([&](OptimizationSettings& s) { s.recommendation = kind; });
    test::FunctionEvaluator evaluator(roll);
    auto record = journal(config::enum_name(kind) + ".db");
    ASSERT_TRUE(optimize(goal, evaluator, record).ok());
    std::set<std::string> kinds;
    for (const auto& f : *record.finalists()) kinds.insert(f.kind);
    std::set<std::string> expected = {"start"};
    if (kind != Recommendation::best) expected.insert("mean");
    if (kind != Recommendation::mean) expected.insert("best");
    EXPECT_EQ(kinds, expected);
  }
}

TEST_F(OptimizationTest, a_race_spends_fewer_rollouts_and_finds_the_same) {
  goal.optimizer.evaluations = 200;
  std::int64_t calls[2] = {0, 0};
  for (const bool race : {false, true}) {
    set([&](OptimizationSettings& s) {
      if (race) s.racing.rounds = {1, 2};
      s.sensitivity = 0;
    });
    test::FunctionEvaluator evaluator(roll);
    auto record = journal(race ? "race.db" : "plain.db");
    const auto result = optimize(goal, evaluator, record);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_EQ(result->success.value(), 1.0);
    calls[race ? 1 : 0] = evaluator.calls;
    int whole = 0, parts = 0;
    for (const auto& e : *record.evaluations()) (e.scenarios == 4 ? whole : parts) += 1;
    if (!race) EXPECT_EQ(parts, 0);
    // Of 10 candidates 5 go on, then 3: 10 + 5 + 2·3 = 21 rollouts instead of 40 a generation.
    if (race) EXPECT_EQ(whole, 20 * 3);
  }
  EXPECT_EQ(calls[0] - calls[1], 20 * (40 - 21));
}

TEST_F(OptimizationTest, a_race_among_equals_drops_nobody_and_its_result_does_not_depend_on_the_order_of_answers) {
  goal.optimizer.evaluations = 60;
  set([](OptimizationSettings& s) {
    s.signal = Signal::binary;
    s.racing.rounds = {1};
  });
  test::FunctionEvaluator hopeless([](const Rollout& r) { return test::bowl(r, 3.0, 0.0); });
  auto flat = journal("flat.db");
  ASSERT_TRUE(optimize(goal, hopeless, flat).ok());
  for (const auto& e : *flat.evaluations()) EXPECT_EQ(e.scenarios, 4);

  set([](OptimizationSettings& s) { s.racing.rounds = {1, 3}; });
  test::FunctionEvaluator forward(roll), backward(roll);
  backward.reverse = true;
  auto one = journal("one.db"), two = journal("two.db");
  EXPECT_EQ(encode(*optimize(goal, forward, one)), encode(*optimize(goal, backward, two)));
}

TEST_F(OptimizationTest, gives_up_only_what_cannot_become_the_best_sample) {
  goal.primitive = test::primitive(1);
  goal.algorithms = {"monte_carlo"};
  goal.restarts = 2;
  const auto course_of = [](const std::vector<EvaluationRecord>& evaluations) {
    std::vector<std::pair<double, int>> best;  // γ and successes of the best so far
    for (const auto& e : evaluations) {
      const bool first = best.empty() || (e.generation == 0 && e.index == 0);
      best.push_back(first || e.gamma > best.back().first ? std::pair{e.gamma, e.successes} : best.back());
    }
    return best;
  };
  const auto run = [&](bool give_up, int& rollouts) {
    set([&](OptimizationSettings& s) { s.give_up = give_up; });
    test::FunctionEvaluator evaluator(roll);
    auto record = journal(give_up ? "given_up.db" : "all.db");
    const auto result = optimize(goal, evaluator, record);
    EXPECT_TRUE(result.ok());
    rollouts = evaluator.calls;
    return std::pair{encode(*result), course_of(*record.evaluations())};
  };
  int all = 0, fewer = 0;
  EXPECT_EQ(run(false, all), run(true, fewer)) << "the same result, and the same best sample after each evaluation";
  EXPECT_LT(fewer, all - 400) << "a quarter of the search at least";
}

TEST_F(OptimizationTest, gives_up_nothing_where_the_optimizer_learns_from_all) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  const auto evaluations = record.evaluations();
  ASSERT_TRUE(evaluations.ok());
  for (const auto& e : *evaluations) EXPECT_EQ(e.scenarios, 4);
}

TEST_F(OptimizationTest, says_what_mattered_around_the_result) {
  // Only the first precision matters, and the last one is at its bound.
  test::FunctionEvaluator evaluator([](const Rollout& r) {
    Rollout one = r;
    one.primitive = test::primitive(1).with_log_rho({r.primitive.log_rho()[0]});
    return test::bowl(one);
  });
  goal.primitive = goal.primitive.with_log_rho({3, 2, 9});
  goal.optimizer.evaluations = 10;
  goal.algorithms = {"monte_carlo"};
  auto record = journal();
  ASSERT_TRUE(optimize(goal, evaluator, record).ok());
  const auto found = record.sensitivities();
  ASSERT_TRUE(found.ok()) << found.error().message;
  ASSERT_EQ(found->size(), 3u);
  // 5 % of −3 … 9 is 0.6; γ by hand at the distance 0.6 from the bowl's middle, with the scenarios' own 0, 0.1, 0.2,
  // 0.3.
  double middle = 0, side = 0;
  for (int k = 0; k < 4; ++k) {
    middle += (0.5 + 0.5 / (1 + 0.1 * k) + 0.6) / 4;
    side += (0.5 + 0.5 / (1 + 0.6 + 0.1 * k) + 0.6) / 4;
  }
  const auto& first = (*found)[0];
  EXPECT_EQ(first.entry, "task_0");
  EXPECT_TRUE(first.log);
  EXPECT_NEAR(first.x[1], 2.4, 1e-12);
  EXPECT_NEAR(first.x[2], 3.6, 1e-12);
  EXPECT_NEAR(first.gamma[0], middle, 1e-9);
  EXPECT_NEAR(first.gamma[1], side, 1e-9);
  EXPECT_NEAR(first.gamma[2], side, 1e-9);
  EXPECT_EQ(first.success[1].trials, 4 * 3);
  EXPECT_NEAR((*found)[1].gamma[1], middle, 1e-9);
  EXPECT_EQ((*found)[2].x[2], 9) << "no step beyond the bound";
}

TEST_F(OptimizationTest, searches_targets_and_fractions_that_the_primitive_declares) {
  auto& task = goal.primitive.tasks[0];
  task.profile = motion::Profile::late;
  task.target = {0.0};
  task.search["target.0"] = {.min = -1, .max = 1};
  task.search["at"] = {.min = 0.5, .max = 0.9};
  task.search["rho"] = {.fixed = true};
  test::FunctionEvaluator evaluator([](const Rollout& r) {
    const auto& t = r.primitive.tasks[0];
    Rollout moved = r;
    moved.primitive = test::primitive(2).with_log_rho({3 + 2 * (t.target[0] - 0.3), 3 + 5 * (t.at - 0.6)});
    return test::bowl(moved);
  });
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_NEAR(result->primitive.tasks[0].target[0], 0.3, 0.1);
  EXPECT_NEAR(result->primitive.tasks[0].at, 0.6, 0.05);
  EXPECT_EQ(result->primitive.tasks[0].rho, goal.primitive.tasks[0].rho);
}

TEST_F(OptimizationTest, tells_every_generation_where_it_stands) {
  goal.optimizer.evaluations = 100;
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  std::vector<Progress> seen;
  ASSERT_TRUE(optimize(goal, evaluator, record, [&](const Progress& p) { seen.push_back(p); }).ok());
  ASSERT_EQ(seen.size(), 10u);
  const auto course = record.evaluations();
  for (std::size_t g = 0; g < seen.size(); ++g) {
    EXPECT_EQ(seen[g].done, 10 * (static_cast<int>(g) + 1));
    EXPECT_GT(seen[g].sigma, 0);
    EXPECT_GE(seen[g].condition, 1);
    EXPECT_EQ(seen[g].success.trials, 4);
    double mean = 0;
    for (std::size_t k = 0; k < 10; ++k) mean += (*course)[10 * g + k].gamma / 10;
    EXPECT_NEAR(seen[g].mean_gamma, mean, 1e-12);
  }
}

TEST_F(OptimizationTest, a_rollout_that_is_not_answered_is_an_error_and_no_zero) {
  class Forgetful : public Evaluator {
    Status evaluate(std::span<const Rollout> rollouts,
                    const std::function<void(std::size_t, RolloutResult)>& on_result) override {
      for (std::size_t i = 0; i + 1 < rollouts.size(); ++i) on_result(i, test::bowl(rollouts[i]));
      return success();
    }
  } evaluator;
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("no fitness of candidate 9 in scenario s3"), std::string::npos)
      << result.error().message;
}

TEST_F(OptimizationTest, refuses_goals_that_cannot_be_run) {
  test::FunctionEvaluator evaluator(roll);
  auto record = journal();
  const auto refused = [&](auto change, const std::string& word) {
    OptimizeGoal wrong = goal;
    change(wrong);
    const auto result = optimize(wrong, evaluator, record);
    ASSERT_FALSE(result.ok()) << word;
    EXPECT_NE(result.error().message.find(word), std::string::npos) << result.error().message;
  };
  refused([](OptimizeGoal& g) { g.scenarios.clear(); }, "scenarios");
  refused([](OptimizeGoal& g) { g.estimates.pop_back(); }, "estimates");
  refused([](OptimizeGoal& g) { g.algorithms = {}; }, "cma");
  refused([](OptimizeGoal& g) { g.algorithms = {"simplex"}; }, "simplex");
  refused([](OptimizeGoal& g) { g.restarts = 0; }, "restarts");
  refused([](OptimizeGoal& g) { g.desired = {}; }, "desired");
  refused([](OptimizeGoal& g) { g.settings = "fitnes: {}"; }, "fitness");
  refused([](OptimizeGoal& g) { g.settings = "racing: {rounds: [2, 2]}"; }, "must rise");
  refused([](OptimizeGoal& g) { g.settings = "signal: loud"; }, "mixed, graded, binary");
  refused([](OptimizeGoal& g) { g.optimizer.evaluations = 9; },
          "a budget of 9 evaluations is below one generation of 10");
  refused([](OptimizeGoal& g) { g.settings = "log_rho_min: 9\nlog_rho_max: 3"; }, "must be below 'log_rho_max'");
  refused(
      [](OptimizeGoal& g) {
        for (auto& task : g.primitive.tasks) task.optimize = false;
      },
      "precision");
}

TEST_F(OptimizationTest, says_why_when_the_planner_refuses) {
  test::FunctionEvaluator evaluator([](const Rollout&) {
    RolloutResult result;
    result.plan_reason = "unknown task variable 'positon'";
    return result;
  });
  auto record = journal();
  const auto result = optimize(goal, evaluator, record);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("positon"), std::string::npos);
}

}  // namespace
}  // namespace primo::study

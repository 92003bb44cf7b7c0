#include "study/figure.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/files.h"
#include "study/curves.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

EvaluationRecord evaluation(int restart, int index, double gamma, int successes) {
  EvaluationRecord record;
  record.algorithm = "cma";
  record.restart = restart;
  record.index = index;
  record.gamma = gamma;
  record.successes = successes;
  record.scenarios = 4;
  return record;
}

TEST(Figures, are_written_as_data_and_as_pictures_that_gnuplot_takes) {
  const fs::path folder = fs::temp_directory_path() / ("primo_figure_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const Figure figure{"it's",
                      "a \"title\", γ",
                      "x",
                      "y_1^2",
                      0,
                      1,
                      {{"P, dashed", {0, 1}, {0.25, 0.5}, {0.1, 0.4}, {0.3, 0.6}, true, 1, true},
                       {"P*", {0, 1}, {1, 1}, {}, {}, false, 0, false}}};
  const auto status = draw(figure, folder);
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(read_file(folder / "it's.csv").value(),
            "series,x,y,low,high\nP; dashed,0,0.25,0.1,0.3\nP; dashed,1,0.5,0.4,0.6\nP*,0,1,,\nP*,1,1,,\n");
  EXPECT_NE(read_file(folder / "it's.svg").value().find("</svg>"), std::string::npos);
  EXPECT_EQ(read_file(folder / "it's.png").value().substr(1, 3), "PNG");
  fs::remove_all(folder);
}

TEST(LearningCurves, are_the_mean_and_standard_error_of_the_best_so_far) {
  const auto curves =
      learning_curves("p", {evaluation(0, 0, 0.5, 2), evaluation(0, 1, 0.2, 4), evaluation(0, 2, 0.9, 4),
                            evaluation(1, 0, 0.1, 0), evaluation(1, 1, 0.3, 1)});
  ASSERT_EQ(curves.gamma.series.size(), 1u);
  const auto& gamma = curves.gamma.series[0];
  EXPECT_EQ(gamma.x, (std::vector<double>{1, 2, 3}));
  EXPECT_NEAR(gamma.y[0], 0.3, 1e-12);
  EXPECT_NEAR(gamma.y[1], 0.4, 1e-12) << "a worse sample does not count";
  EXPECT_NEAR(gamma.y[2], 0.6, 1e-12) << "a run that ended keeps its last";
  // Two values a and b: standard error |a − b| / 2.
  EXPECT_NEAR(gamma.high[0] - gamma.y[0], 0.2, 1e-12);
  EXPECT_NEAR(gamma.y[2] - gamma.low[2], 0.3, 1e-12);
  const auto& success = curves.success.series[0];
  EXPECT_NEAR(success.y[1], (0.5 + 0.25) / 2, 1e-12) << "the success of the best by γ, not the best success";
}

TEST(SearchSummary, counts_restarts_and_the_evaluations_that_success_took) {
  FinalistRecord worse, better;
  worse.algorithm = better.algorithm = "cma";
  worse.kind = "best";
  better.kind = "mean";
  worse.gamma = 1;
  worse.success = {3, 8};
  better.gamma = 2;
  better.success = {8, 8};
  const auto summaries =
      summarize_searches({evaluation(0, 0, 0.5, 2), evaluation(0, 1, 0.2, 3), evaluation(0, 2, 0.9, 4),
                          evaluation(1, 0, 0.1, 0), evaluation(1, 1, 0.3, 3)},
                         {worse, better});
  ASSERT_EQ(summaries.size(), 1u);
  const auto& cma = summaries[0];
  EXPECT_EQ(cma.restarts, 2);
  EXPECT_EQ(cma.scenarios, 4);
  EXPECT_EQ(cma.everywhere.successes, 1);
  EXPECT_EQ(cma.everywhere.trials, 2);
  EXPECT_DOUBLE_EQ(cma.evaluations_mean, 3);
  EXPECT_DOUBLE_EQ(cma.all_but_one_mean, 2);
  EXPECT_EQ(cma.recommended.successes, 8) << "the better of a restart's recommendations counts";
  EXPECT_EQ(cma.recommended_everywhere.trials, 1) << "restart 1 has no finalists here";
}

TEST(SearchSummary, does_not_take_a_dropped_candidate_for_one_that_met_all_scenarios) {
  auto dropped = evaluation(0, 0, 0.9, 2);
  dropped.scenarios = 2;
  const auto summaries = summarize_searches({dropped, evaluation(0, 1, 0.5, 2), evaluation(0, 2, 1.5, 4)}, {});
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].scenarios, 4);
  EXPECT_DOUBLE_EQ(summaries[0].evaluations_mean, 3);
}

TEST(GeneralizationFigures, leave_out_what_was_not_tried) {
  PartResult part;
  part.name = "grasp";
  part.levels.resize(2);
  part.levels[1].displacement = 0.03;
  for (auto& level : part.levels) {
    level.before.strict = {3, 10};
    level.after.strict = {10, 10};
  }
  const auto figures = generalization_figures(part);
  ASSERT_EQ(figures.size(), 3u);
  EXPECT_TRUE(figures[0].series.empty());
  EXPECT_TRUE(figures[2].series.empty());
  ASSERT_EQ(figures[1].series.size(), 2u);
  EXPECT_TRUE(figures[1].series[0].dashed);
  EXPECT_EQ(figures[1].series[1].x, (std::vector<double>{0, 3}));
  EXPECT_DOUBLE_EQ(figures[1].series[0].low[0], (Rate{3, 10}).lower());
}

}  // namespace
}  // namespace primo::study

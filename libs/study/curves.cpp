#include "study/curves.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace primo::study {
namespace {

/// Points of a line at most: about one a pixel.
constexpr std::size_t kMostPoints = 500;

/// Best so far after each evaluation of one restart.
struct Course {
  std::vector<double> gamma, success;
};

/// Mean and standard error over restarts, after each evaluation.
struct Line {
  std::vector<double> mean, error;
};

std::map<std::string, std::map<int, Course>> courses_of(const std::vector<EvaluationRecord>& evaluations) {
  std::map<std::string, std::map<int, Course>> courses;
  for (const auto& e : evaluations) {
    auto& course = courses[e.algorithm + (e.round > 0 ? ", round " + std::to_string(e.round + 1) : "")][e.restart];
    const double success = e.scenarios > 0 ? static_cast<double>(e.successes) / e.scenarios : 0;
    if (course.gamma.empty() || e.gamma > course.gamma.back()) {
      course.gamma.push_back(e.gamma);
      course.success.push_back(success);
    } else {
      course.gamma.push_back(course.gamma.back());
      course.success.push_back(course.success.back());
    }
  }
  return courses;
}

Line line_of(const std::map<int, Course>& restarts,
             const std::function<const std::vector<double>&(const Course&)>& values) {
  std::size_t length = 0;
  for (const auto& [restart, course] : restarts) length = std::max(length, values(course).size());
  Line line;
  for (std::size_t n = 0; n < length; ++n) {
    double sum = 0, squares = 0;
    for (const auto& [restart, course] : restarts) {
      const auto& v = values(course);
      const double value = v[std::min(n, v.size() - 1)];  // one that stopped early keeps its best
      sum += value;
      squares += value * value;
    }
    const double count = static_cast<double>(restarts.size());
    const double mean = sum / count;
    line.mean.push_back(mean);
    line.error.push_back(count > 1 ? std::sqrt(std::max(0.0, squares / count - mean * mean) / (count - 1)) : 0.0);
  }
  return line;
}

Series series_of(const Line& line, const std::string& label, int colour, double low, double high) {
  Series series;
  series.label = label;
  series.colour = colour;
  const std::size_t stride = std::max<std::size_t>(1, line.mean.size() / kMostPoints);
  const auto add = [&](std::size_t n) {
    series.x.push_back(static_cast<double>(n + 1));
    series.y.push_back(line.mean[n]);
    series.low.push_back(std::max(low, line.mean[n] - line.error[n]));
    series.high.push_back(std::min(high, line.mean[n] + line.error[n]));
  };
  for (std::size_t n = 0; n + 1 < line.mean.size(); n += stride) add(n);
  if (!line.mean.empty()) add(line.mean.size() - 1);
  return series;
}

/// A rate of all levels, by what picks it.
Series rates_of(const PartResult& part, const std::string& label,
                const std::function<const Rate&(const Level&)>& rate_of) {
  Series series;
  series.label = label;
  series.bars = true;
  for (const auto& level : part.levels) {
    const Rate& rate = rate_of(level);
    if (rate.trials == 0) continue;
    series.x.push_back(100 * level.displacement);
    series.y.push_back(rate.value());
    series.low.push_back(rate.lower());
    series.high.push_back(rate.upper());
  }
  return series;
}

}  // namespace

LearningCurves learning_curves(const std::string& part, const std::vector<EvaluationRecord>& evaluations) {
  LearningCurves curves;
  curves.success = {part + "_success", "", "evaluations of γ", "success rate of the best so far", 0, 1.02, {}};
  curves.gamma = {part + "_gamma", "", "evaluations of γ", "γ of the best so far", 0, 0, {}};
  int colour = 0;
  for (const auto& [algorithm, restarts] : courses_of(evaluations)) {
    const std::string label =
        algorithm + (restarts.size() > 1 ? ", mean of " + std::to_string(restarts.size()) + " restarts" : "");
    const auto success = line_of(
        restarts, [](const Course& c) -> const auto& { return c.success; });
    const auto gamma = line_of(
        restarts, [](const Course& c) -> const auto& { return c.gamma; });
    curves.success.series.push_back(series_of(success, label, colour, 0, 1));
    curves.gamma.series.push_back(series_of(gamma, label, colour, -1e9, 1e9));
    ++colour;
  }
  return curves;
}

std::vector<Figure> generalization_figures(const PartResult& part) {
  struct Kind {
    const char *name, *label;
    Rate LevelRates::*rate;
  };
  static constexpr Kind kKinds[] = {{"final_pose", "final pose", &LevelRates::final_pose},
                                    {"strict", "strict success", &LevelRates::strict},
                                    {"executed", "executed in full physics", &LevelRates::executed}};
  std::vector<Figure> figures;
  for (const auto& kind : kKinds) {
    Figure figure{part.name + "_generalization_" + kind.name,
                  "",
                  "displacement of every object, ± cm",
                  std::string(kind.label) + ", rate",
                  0,
                  1.02,
                  {}};
    const auto rate = kind.rate;
    auto before = rates_of(part, "P, hand-tuned", [rate](const Level& l) -> const Rate& { return l.before.*rate; });
    auto after = rates_of(part, "P*, optimized", [rate](const Level& l) -> const Rate& { return l.after.*rate; });
    before.dashed = true;
    before.colour = 1;
    if (!before.x.empty()) figure.series = {std::move(before), std::move(after)};
    figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace primo::study

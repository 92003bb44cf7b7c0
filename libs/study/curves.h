// The figures that a study's records make (paper, Figures 2, 3, 5 and 6).
#pragma once

#include "study/figure.h"
#include "study/journal.h"
#include "study/result.h"

namespace primo::study {

/// Success rate and γ of the best candidate so far (by γ) against evaluations: for each algorithm the mean over its
/// restarts, with its standard error. One that ended early keeps its last value. @pre all of one part.
struct LearningCurves {
  Figure success, gamma;
};
LearningCurves learning_curves(const std::string& part, const std::vector<EvaluationRecord>& evaluations);

/// How the searches of one algorithm went in the first round.
struct SearchSummary {
  std::string algorithm;
  int restarts = 0;
  int scenarios = 0;             ///< K
  Rate everywhere;               ///< restarts in which some candidate succeeded in all K
  double evaluations_mean = 0;   ///< until then, over those; 0 where there are none
  double evaluations_worst = 0;  ///< the largest of them
  Rate all_but_one_restarts;     ///< restarts in which some candidate succeeded in all but one
  double all_but_one_mean = 0;   ///< evaluations until then
  Rate recommended_everywhere;   ///< restarts whose better recommendation succeeded in every trial with fresh seeds
  Rate recommended;              ///< trials of these recommendations, over all restarts
};

/// One for each algorithm. @pre all of one part.
std::vector<SearchSummary> summarize_searches(const std::vector<EvaluationRecord>& evaluations,
                                              const std::vector<FinalistRecord>& finalists);

/// Success against displacement, P dashed, P* solid, with 95 % intervals. Three figures: final poses, strict,
/// executed; the last is without series where nothing was executed.
std::vector<Figure> generalization_figures(const PartResult& part);

}  // namespace primo::study

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

/// Success against displacement, P dashed, P* solid, with 95 % intervals. Three figures: final poses, strict,
/// executed; the last is without series where nothing was executed.
std::vector<Figure> generalization_figures(const PartResult& part);

}  // namespace primo::study

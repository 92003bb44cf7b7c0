#include "rules/score.h"

#include <algorithm>
#include <cmath>

namespace primo::rules {

std::int64_t penalty(const RuleSet& rules) {
  std::size_t literals = 0;
  for (const auto& rule : rules.rules) {
    literals += rule.context.size();
    for (const auto& outcome : rule.outcomes) literals += outcome.literals.size();
  }
  return static_cast<std::int64_t>(literals);
}

double likelihood(const Predictor& predictor, const symbols::Experience& experience, double p_min) {
  const auto prediction = predictor.predict(experience.objects, experience.before, experience.action);
  double p = p_min * prediction.noise;
  for (const auto& successor : prediction.successors) {
    if (successor.state == experience.after) p += successor.p;
  }
  return p;
}

Score assess(const RuleSet& rules, const std::vector<symbols::Experience>& experiences, double p_min) {
  constexpr double kSmallest = 1e-300;  // keeps the sum finite
  const Predictor predictor(rules);
  Score score{.penalty = penalty(rules)};
  for (const auto& experience : experiences) {
    const double p = likelihood(predictor, experience, p_min);
    score.impossible += !(p > 0);
    score.log_likelihood += std::log(std::max(p, kSmallest));
  }
  return score;
}

double score(const RuleSet& rules, const std::vector<symbols::Experience>& experiences,
             const LearnerSettings& settings) {
  return assess(rules, experiences, settings.p_min).total(settings.alpha);
}

}  // namespace primo::rules

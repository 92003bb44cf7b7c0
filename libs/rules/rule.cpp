#include "rules/rule.h"

#include <algorithm>

namespace primo::rules {

std::int64_t Rule::trials() const {
  if (examples > 0) return examples;
  std::int64_t sum = noise_count;
  for (const auto& outcome : outcomes) sum += outcome.count;
  return sum;
}

int desired_index(const Rule& rule) {
  int best = -1;
  for (std::size_t i = 0; i < rule.outcomes.size(); ++i) {
    const auto& outcome = rule.outcomes[i];
    if (outcome.literals.empty()) continue;
    if (best < 0 || outcome.p > rule.outcomes[static_cast<std::size_t>(best)].p) best = static_cast<int>(i);
  }
  return best;
}

Rule project_to_desired(const Rule& rule) {
  Rule projected{.action = rule.action, .context = rule.context, .outcomes = {}, .noise = 1};
  const std::int64_t trials = rule.trials();
  projected.noise_count = trials;
  const int index = desired_index(rule);
  if (index < 0) return projected;
  RuleOutcome desired = rule.outcomes[static_cast<std::size_t>(index)];
  // With counts: what maximises the likelihood when everything else is noise. Without: what the rule states.
  if (trials > 0) desired.p = static_cast<double>(desired.count) / static_cast<double>(trials);
  projected.noise = 1 - desired.p;
  projected.noise_count = trials - desired.count;
  projected.outcomes.push_back(std::move(desired));
  return projected;
}

}  // namespace primo::rules

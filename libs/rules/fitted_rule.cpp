#include "rules/fitted_rule.h"

#include <algorithm>
#include <numeric>

#include "core/hash.h"

namespace primo::rules {
namespace {

void renumber(std::vector<LiftedLiteral>& context, const std::vector<std::int16_t>& numbers) {
  for (auto& literal : context) {
    for (std::size_t i = 1; i < literal.atom.size() && literal.atom[i] != -1; ++i) {
      literal.atom[i] = numbers[static_cast<std::size_t>(literal.atom[i])];
    }
  }
  std::sort(context.begin(), context.end());
}

bool over_arguments_only(const LiftedLiteral& literal, int arguments) {
  return std::all_of(literal.atom.begin() + 1, literal.atom.end(), [&](std::int16_t term) { return term < arguments; });
}

}  // namespace

RuleKey canonical(RuleKey key) {
  const int arguments = key.arguments();
  std::vector<bool> used(static_cast<std::size_t>(key.variables), false);
  for (const auto& literal : key.context) {
    for (std::size_t i = 1; i < literal.atom.size() && literal.atom[i] != -1; ++i) {
      used[static_cast<std::size_t>(literal.atom[i])] = true;
    }
  }
  std::vector<std::int16_t> numbers(static_cast<std::size_t>(key.variables));
  int next = arguments;
  for (int v = 0; v < key.variables; ++v) {
    const bool kept = v < arguments || used[static_cast<std::size_t>(v)];
    numbers[static_cast<std::size_t>(v)] = static_cast<std::int16_t>(v < arguments ? v : (kept ? next++ : 0));
  }
  key.variables = next;
  renumber(key.context, numbers);
  key.context.erase(std::unique(key.context.begin(), key.context.end()), key.context.end());
  if (key.references() < 2) return key;

  RuleKey best = key;
  numbers.resize(static_cast<std::size_t>(key.variables));
  std::iota(numbers.begin(), numbers.end(), std::int16_t{0});
  while (std::next_permutation(numbers.begin() + arguments, numbers.end())) {
    RuleKey other = key;
    renumber(other.context, numbers);
    if (other.context < best.context) best = std::move(other);
  }
  return best;
}

std::vector<std::int16_t> action_terms(const Scene& scene) {
  std::vector<std::int16_t> terms, objects;
  for (const auto object : scene.action) {
    const auto at = std::find(objects.begin(), objects.end(), object);
    terms.push_back(static_cast<std::int16_t>(at - objects.begin()));
    if (at == objects.end()) objects.push_back(object);
  }
  return terms;
}

ActionExamples::ActionExamples(std::vector<Scene> scenes, const LearnerSettings& settings)
    : scenes_(std::move(scenes)), settings_(settings), all_(scenes_.size()), changed_(scenes_.size()) {
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    all_.set(i);
    if (!scenes_[i].changes.empty()) changed_.set(i);
  }
}

const Bits& ActionExamples::satisfied(const RuleKey& key, const LiftedLiteral& literal) {
  const auto [at, fresh] = satisfied_.try_emplace({key.action, literal}, scenes_.size());
  if (!fresh) return at->second;
  const Pattern pattern(key.action, key.arguments(), {literal});
  std::vector<std::int16_t> binding;
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    if (pattern.count_bindings(scenes_[i], binding) == 1) at->second.set(i);
  }
  return at->second;
}

bool ActionExamples::bind_scene(const RuleKey& key, std::size_t scene, std::vector<std::int16_t>& binding) const {
  return Pattern(key.action, key.variables, key.context).count_bindings(scenes_[scene], binding) == 1;
}

const FittedRule& ActionExamples::fit(const RuleKey& key) {
  const auto [at, fresh] = fits_.try_emplace(key);
  FittedRule& fitted = at->second;
  if (!fresh) return fitted;

  Bits possible = all_;
  std::vector<LiftedLiteral> deictic;
  for (const auto& literal : key.context) {
    if (over_arguments_only(literal, key.arguments())) {
      possible &= satisfied(key, literal);
    } else {
      deictic.push_back(literal);
    }
  }
  const Pattern pattern(key.action, key.variables, deictic);
  fitted.covered = Bits(scenes_.size());
  std::vector<EffectCase> cases;
  Hasher identity;
  std::vector<std::int16_t> binding;
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    if (!possible.test(i) || pattern.count_bindings(scenes_[i], binding) != 1) continue;
    fitted.covered.set(i);
    cases.push_back({&scenes_[i], binding});
    identity.add(static_cast<std::uint64_t>(i)).add(binding);
  }
  if (cases.empty()) return fitted;
  auto& induced = induced_[identity.value()];
  if (!induced) {
    induced = std::make_shared<const InducedOutcomes>(induce_outcomes(cases, settings_.alpha, settings_.p_min));
  }
  fitted.induced = induced;
  fitted.score = induced->score - settings_.alpha * static_cast<double>(key.context.size());
  return fitted;
}

DefaultRule ActionExamples::default_rule(const Bits& covered, double* log_likelihood) const {
  Bits rest = all_;
  rest.remove(covered);
  Bits changed = changed_;
  changed &= rest;
  DefaultRule rule;
  rule.noise_count = changed.count();
  rule.no_change_count = rest.count() - rule.noise_count;
  std::vector<MixtureCell> cells;
  if (rule.no_change_count > 0) cells.push_back({{0}, static_cast<double>(rule.no_change_count)});
  if (rule.noise_count > 0) cells.push_back({{}, static_cast<double>(rule.noise_count)});
  const auto fit = fit_outcomes(cells, 1, settings_.p_min);
  rule.no_change = fit.p[0];
  rule.noise = fit.noise;
  if (log_likelihood) *log_likelihood = fit.log_likelihood;
  return rule;
}

}  // namespace primo::rules

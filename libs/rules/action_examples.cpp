#include "rules/action_examples.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace primo::rules {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{192} << 20;
constexpr double kOmitted = 3;             // times what a required literal earns (decision 0308)
constexpr double kGuessed = 10;            // examples from which on a guess costs less (decision 0309)
constexpr std::size_t kBitsAVariable = 5;  // in the key of an example's changes

/// The change of a scene over the rule's variables; empty when an object that changes is neither bound nor a constant.
std::optional<Outcome> lifted_change(const Scene& scene, const std::int16_t* binding, int variables) {
  Outcome change = scene.changes;
  for (auto& literal : change) {
    for (auto& term : terms(literal.atom)) {
      const auto* at = std::find(binding, binding + variables, term);
      if (at != binding + variables) {
        term = static_cast<std::int16_t>(at - binding);
        continue;
      }
      const auto k = std::find(scene.constants.begin(), scene.constants.end(), term) - scene.constants.begin();
      if (k == static_cast<std::ptrdiff_t>(scene.constants.size())) return std::nullopt;
      term = constant(static_cast<int>(k));
    }
  }
  std::sort(change.begin(), change.end());
  return change;
}

/// The positive literals that outcomes make false, each by its outcome's probability. What the context does not have
/// counts against the rule.
double undone(const RuleKey& key, const InducedOutcomes& induced) {
  double sum = 0;
  for (std::size_t i = 0; i < induced.outcomes.size(); ++i) {
    for (LiftedLiteral literal : induced.outcomes[i]) {
      if (!literal.negated || literal.relation != Relation::none) continue;
      literal.negated = false;
      const bool required = std::binary_search(key.context.begin(), key.context.end(), literal);
      sum += induced.fit.p[i] * (required ? 1 : -kOmitted);
    }
  }
  return sum;
}

/// Whether a context literal may well hold by chance in the few examples there are: it says something of one object or
/// of none that actions change, and is not what this action undoes. A relation names an object.
bool is_guess(LiftedLiteral literal, const InducedOutcomes& induced, const std::set<std::int16_t>& changing) {
  if (literal.relation != Relation::none || terms(literal.atom).size() > 1) return false;
  if (!changing.contains(literal.atom[0])) return false;
  if (literal.negated) return true;
  literal.negated = true;
  return std::none_of(induced.outcomes.begin(), induced.outcomes.end(), [&](const Outcome& outcome) {
    return std::find(outcome.begin(), outcome.end(), literal) != outcome.end();
  });
}

/// What the context costs beside α. What holds in many examples holds less easily by chance.
double length(const RuleKey& key, const InducedOutcomes& induced, std::size_t examples,
              const std::set<std::int16_t>& changing, const LearnerSettings& settings) {
  const double guess = settings.guess * std::min(1.0, kGuessed / static_cast<double>(examples));
  double nats = 0;
  for (const auto& literal : key.context) {
    nats += settings.term * static_cast<double>(terms(literal.atom).size());
    if (literal.negated) nats += settings.negation;
    if (is_guess(literal, induced, changing)) nats += guess;
  }
  return nats;
}

std::vector<std::int16_t> changed_objects(const Scene& scene) {
  std::vector<std::int16_t> objects;
  for (const auto& change : scene.changes) {
    for (const auto term : terms(change.atom)) objects.push_back(term);
  }
  std::sort(objects.begin(), objects.end());
  objects.erase(std::unique(objects.begin(), objects.end()), objects.end());
  return objects;
}

}  // namespace

void ActionExamples::extend() {
  const std::size_t old = known_changes_.size();
  if (old == scenes_.size()) return;
  all_.resize(scenes_.size());
  unchanged_.resize(scenes_.size());
  known_changes_.resize(scenes_.size());
  for (std::size_t i = old; i < scenes_.size(); ++i) {
    all_.set(i);
    if (scenes_[i].changes.empty()) unchanged_.set(i);
    changed_objects_.push_back(changed_objects(scenes_[i]));
  }
}

int ActionExamples::change(const Covered& covered, std::size_t i) {
  const auto* binding = covered.binding(i);
  const std::size_t example = covered.examples[i];
  const auto& objects = changed_objects_[example];
  const bool short_key = objects.size() * kBitsAVariable <= 64 && covered.variables < (1 << kBitsAVariable) - 1;
  std::uint64_t key = 0;
  for (const auto object : objects) {
    const auto at = std::find(binding, binding + covered.variables, object) - binding;
    key = (key << kBitsAVariable) | static_cast<std::uint64_t>(at == covered.variables ? 0 : at + 1);
  }
  auto& known = known_changes_[example];
  if (short_key) {
    for (const auto& [k, number] : known) {
      if (k == key) return number;
    }
  }
  int number = -1;
  if (const auto lifted = lifted_change(scenes_[example], binding, covered.variables)) {
    const auto [at, fresh] = numbers_.try_emplace(*lifted, static_cast<int>(changes_.size()));
    if (fresh) changes_.push_back(&at->first);
    number = at->second;
  }
  if (short_key) known.emplace_back(key, number);
  return number;
}

void ActionExamples::refit(const RuleKey& key, FittedRule& fitted) {
  const Covered covered = coverage_.cover(key);
  fitted.covered = Bits(scenes_.size());
  fitted.induced.reset();
  fitted.score = 0;
  std::vector<int> numbers(covered.size());
  std::vector<bool> used(static_cast<std::size_t>(key.variables));
  std::vector<bool> seen(changes_.size());
  for (std::size_t i = 0; i < covered.size(); ++i) {
    fitted.covered.set(covered.examples[i]);
    const int number = numbers[i] = change(covered, i);
    if (number < 0) continue;
    seen.resize(std::max(seen.size(), changes_.size()));
    if (seen[static_cast<std::size_t>(number)]) continue;
    seen[static_cast<std::size_t>(number)] = true;
    for (const auto& literal : *changes_[static_cast<std::size_t>(number)]) {
      for (const auto term : terms(literal.atom)) {
        if (term >= 0) used[static_cast<std::size_t>(term)] = true;
      }
    }
  }
  if (covered.size() == 0) return;
  Hasher identity;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    std::uint64_t word = (std::uint64_t{covered.examples[i]} << 32) ^ static_cast<std::uint32_t>(numbers[i]);
    identity.add(word);
    // Which objects the variables are matters only where an outcome may speak of them.
    word = 0;
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (used[v]) word = (word << 16) ^ (word >> 48) ^ static_cast<std::uint64_t>(covered.binding(i)[v] + 1);
    }
    identity.add(word);
  }
  auto& induced = induced_[identity.value()];
  if (!induced) {
    induced = std::make_shared<const InducedOutcomes>(
        induce_outcomes(scenes_, covered, numbers, changes_, settings_.alpha, settings_.p_min));
  }
  fitted.induced = induced;
  fitted.score = induced->score - settings_.alpha * static_cast<double>(key.context.size()) +
                 settings_.requirement * undone(key, *induced) -
                 length(key, *induced, covered.size(), changing_, settings_);
}

const FittedRule& ActionExamples::fit(const RuleKey& key) {
  extend();
  const auto [at, fresh] = fits_.try_emplace(key);
  FittedRule& fitted = at->second;
  if (!fresh && fitted.seen == scenes_.size()) return fitted;
  if (!fresh && coverage_.cover(key, fitted.seen).size() == 0) {
    fitted.covered.resize(scenes_.size());
  } else {
    refit(key, fitted);
  }
  fitted.seen = scenes_.size();
  return fitted;
}

DefaultRule ActionExamples::default_rule(const Bits& covered, double* log_likelihood) {
  extend();
  const std::int64_t rest = all_.count_without(covered);
  DefaultRule rule;
  rule.no_change_count = unchanged_.count_without(covered);
  rule.noise_count = rest - rule.no_change_count;
  std::vector<MixtureCell> cells;
  if (rule.no_change_count > 0) cells.push_back({{0}, static_cast<double>(rule.no_change_count)});
  if (rule.noise_count > 0) cells.push_back({{}, static_cast<double>(rule.noise_count)});
  const auto fit = fit_outcomes(cells, 1, settings_.p_min);
  rule.no_change = fit.p[0];
  rule.noise = fit.noise;
  if (log_likelihood) *log_likelihood = fit.log_likelihood;
  return rule;
}

void ActionExamples::limit_memory() {
  coverage_.limit_memory();
  const std::size_t each = scenes_.size() / 8 + 400;
  if (fits_.size() * each > kMaxBytes) fits_.clear();
  if (induced_.size() * 600 > kMaxBytes) induced_.clear();
}

}  // namespace primo::rules

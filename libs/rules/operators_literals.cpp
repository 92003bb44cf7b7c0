// Operators that add literals or change those of functions and constants.
#include <algorithm>
#include <map>

#include "rules/operators.h"

namespace primo::rules {
namespace {

using Values = std::set<std::int32_t>;

constexpr std::size_t kMaxValues = 24;  // bounds tried of one function

/// At most kMaxValues of them, evenly spread.
std::vector<std::int32_t> thinned(const Values& values) {
  const std::vector<std::int32_t> all(values.begin(), values.end());
  if (all.size() <= kMaxValues) return all;
  std::vector<std::int32_t> some;
  for (std::size_t i = 0; i < kMaxValues; ++i) some.push_back(all[i * (all.size() - 1) / (kMaxValues - 1)]);
  return some;
}

LiftedLiteral range(const Atom& function, Relation relation, std::int32_t value) {
  return {.atom = function, .relation = relation, .negated = false, .value = value};
}

bool speaks_of(const RuleKey& key, const LiftedLiteral& literal, bool of_ranges_too) {
  return std::any_of(key.context.begin(), key.context.end(), [&](const LiftedLiteral& other) {
    if (other.atom != literal.atom) return false;
    return of_ranges_too || (other.relation == Relation::equal && !other.negated);
  });
}

void insert_sorted(std::vector<RuleKey> rules, Replacements& found) {
  std::sort(rules.begin(), rules.end());
  found.insert(std::move(rules));
}

/// Each of the literals alone, and one rule for each.
void add_alternatives(const RuleKey& key, const std::vector<LiftedLiteral>& literals, Replacements& found) {
  std::vector<RuleKey> all;
  for (const auto& literal : literals) {
    all.push_back(with(key, {literal}, key.variables));
    found.insert({all.back()});
  }
  insert_sorted(std::move(all), found);
}

void add_values(const RuleKey& key, const Atom& function, const Values& values, Replacements& found) {
  const auto bounds = thinned(values);
  std::vector<LiftedLiteral> each;
  for (const auto value : bounds) each.push_back(range(function, Relation::equal, value));
  if (each.size() > 2) add_alternatives(key, each, found);
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    add_alternatives(
        key, {range(function, Relation::at_most, bounds[i]), range(function, Relation::at_least, bounds[i + 1])},
        found);
  }
}

/// The rule with a constant or variable replaced in action and context.
RuleKey replaced(RuleKey key, std::int16_t from, std::int16_t to, int variables) {
  const auto replace = [&](auto&& range) { std::replace(range.begin(), range.end(), from, to); };
  replace(key.action);
  for (auto& literal : key.context) replace(terms(literal.atom));
  key.variables = variables;
  return canonical(std::move(key));
}

}  // namespace

void add_literals(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  std::set<LiftedLiteral> known;
  std::map<Atom, Values> values;
  const Covered covered = examples.cover(key);
  for (std::size_t i = 0; i < covered.size(); ++i) {
    const std::vector<std::int16_t> binding(covered.binding(i), covered.binding(i) + key.variables);
    for (const auto& literal : lifted_literals(examples.scenes()[covered.examples[i]], binding)) {
      known.insert(literal);
      if (literal.relation != Relation::none) values[literal.atom].insert(literal.value);
    }
  }
  for (const auto& literal : known) {
    if (speaks_of(key, literal, literal.relation == Relation::none)) continue;
    LiftedLiteral absent = literal;
    absent.negated = true;
    add_alternatives(key, {literal, absent}, found);
  }
  for (const auto& [function, seen] : values) {
    if (seen.size() > 1) add_values(key, function, seen, found);
  }
}

void change_values(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  for (const auto& literal : key.context) {
    if (literal.relation == Relation::none || literal.negated) continue;
    const auto exchanged = [&](Relation relation, std::int32_t value) {
      RuleKey other = key;
      for (auto& l : other.context) {
        if (l == literal) l = range(literal.atom, relation, value);
      }
      return canonical(std::move(other));
    };
    if (literal.relation == Relation::equal) {
      found.insert({exchanged(Relation::at_least, literal.value)});
      found.insert({exchanged(Relation::at_most, literal.value)});
      continue;
    }
    Values seen;
    for (const auto& scene : examples.scenes()) {
      for (const auto& [atom, value] : scene.values) {
        if (atom[0] == literal.atom[0]) seen.insert(value);
      }
    }
    for (const auto value : thinned(seen)) found.insert({exchanged(literal.relation, value)});
  }
}

void change_constants(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  const auto& scenes = examples.scenes();
  if (scenes.empty() || scenes.front().constants.empty()) return;
  const Covered covered = examples.cover(key);
  for (std::int16_t v = 0; v < key.variables; ++v) {
    std::set<std::int16_t> taken;
    for (std::size_t i = 0; i < covered.size(); ++i) {
      const auto& constants = scenes[covered.examples[i]].constants;
      const auto k = std::find(constants.begin(), constants.end(), covered.binding(i)[v]) - constants.begin();
      if (k < static_cast<std::ptrdiff_t>(constants.size())) taken.insert(constant(static_cast<int>(k)));
    }
    std::vector<RuleKey> all;
    for (const auto k : taken) {
      all.push_back(replaced(key, v, k, key.variables));
      found.insert({all.back()});
    }
    if (!all.empty()) insert_sorted(std::move(all), found);
  }
  for (std::size_t k = 0; k < scenes.front().constants.size(); ++k) {
    const auto term = constant(static_cast<int>(k));
    RuleKey raised = replaced(key, term, static_cast<std::int16_t>(key.variables), key.variables + 1);
    if (raised != key) found.insert({std::move(raised)});
  }
}

}  // namespace primo::rules

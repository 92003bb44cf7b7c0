#include "rules/rule_key.h"

#include <algorithm>
#include <numeric>

namespace primo::rules {
namespace {

using Numbers = std::vector<std::int16_t>;

void renumber(std::vector<LiftedLiteral>& context, const Numbers& numbers) {
  for (auto& literal : context) {
    for (auto& term : terms(literal.atom)) {
      if (term >= 0) term = numbers[static_cast<std::size_t>(term)];
    }
  }
  std::sort(context.begin(), context.end());
}

/// The action's variables in the order in which they occur, then the deictic ones that occur; −1: gone.
Numbers compact(const RuleKey& key) {
  Numbers numbers(static_cast<std::size_t>(key.variables), -1);
  std::int16_t next = 0;
  for (const auto term : key.action) {
    if (term >= 0 && numbers[static_cast<std::size_t>(term)] < 0) numbers[static_cast<std::size_t>(term)] = next++;
  }
  std::vector<bool> used(numbers.size());
  for (const auto& literal : key.context) {
    for (const auto term : terms(literal.atom)) {
      if (term >= 0) used[static_cast<std::size_t>(term)] = true;
    }
  }
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] < 0 && used[v]) numbers[v] = next++;
  }
  return numbers;
}

}  // namespace

RuleKey canonical(RuleKey key) {
  Numbers numbers = compact(key);
  for (auto& term : key.action) {
    if (term >= 0) term = numbers[static_cast<std::size_t>(term)];
  }
  key.variables = static_cast<int>(std::count_if(numbers.begin(), numbers.end(), [](auto n) { return n >= 0; }));
  renumber(key.context, numbers);
  key.context.erase(std::unique(key.context.begin(), key.context.end()), key.context.end());
  if (key.references() < 2) return key;

  RuleKey best = key;
  numbers.resize(static_cast<std::size_t>(key.variables));
  std::iota(numbers.begin(), numbers.end(), std::int16_t{0});
  while (std::next_permutation(numbers.begin() + key.arguments(), numbers.end())) {
    RuleKey other = key;
    renumber(other.context, numbers);
    if (other.context < best.context) best = std::move(other);
  }
  return best;
}

std::vector<std::int16_t> action_terms(const Scene& scene) {
  std::vector<std::int16_t> variables, objects;
  for (const auto object : scene.action) {
    const auto at = std::find(objects.begin(), objects.end(), object);
    variables.push_back(static_cast<std::int16_t>(at - objects.begin()));
    if (at == objects.end()) objects.push_back(object);
  }
  return variables;
}

std::size_t RuleKeyHash::operator()(const RuleKey& key) const {
  Hasher hasher;
  hasher.add(key.action).add(key.variables);
  for (const auto& literal : key.context) add(hasher, literal);
  return hasher.value();
}

std::size_t LiteralHash::operator()(const LiftedLiteral& literal) const {
  Hasher hasher;
  return add(hasher, literal).value();
}

}  // namespace primo::rules

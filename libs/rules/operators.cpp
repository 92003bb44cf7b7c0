#include "rules/operators.h"

#include <algorithm>
#include <limits>

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

using Binding = std::vector<std::int16_t>;

bool is_bound(const Binding& bound, int object) { return std::find(bound.begin(), bound.end(), object) != bound.end(); }

/// Replaces objects by variables and constants; false when one is neither.
bool lift(const Scene& scene, const Binding& bound, Atom& atom) {
  for (auto& term : terms(atom)) {
    if (const auto at = std::find(bound.begin(), bound.end(), term); at != bound.end()) {
      term = static_cast<std::int16_t>(at - bound.begin());
    } else if (const auto k = std::find(scene.constants.begin(), scene.constants.end(), term);
               k != scene.constants.end()) {
      term = constant(static_cast<int>(k - scene.constants.begin()));
    } else {
      return false;
    }
  }
  return true;
}

/// All that holds of an object beside the bound ones: the literals that mention it, as the variable after the bound
/// ones.
std::vector<LiftedLiteral> description(const Scene& scene, Binding bound, std::int16_t object) {
  bound.push_back(object);
  auto literals = lifted_literals(scene, bound);
  std::erase_if(literals,
                [&](const LiftedLiteral& literal) { return !mentions(literal, static_cast<int>(bound.size()) - 1); });
  return literals;
}

/// Whether no other object fits the description.
bool singles_out(const Scene& scene, const Binding& bound, const std::vector<LiftedLiteral>& literals) {
  int fitting = 0;
  Binding extended = bound;
  extended.push_back(-1);
  for (int object = 0; object < scene.objects && fitting < 2; ++object) {
    if (is_bound(bound, object)) continue;
    extended.back() = static_cast<std::int16_t>(object);
    fitting += std::all_of(literals.begin(), literals.end(),
                           [&](const LiftedLiteral& literal) { return holds(scene, literal, extended); });
  }
  return fitting == 1;
}

std::set<std::int16_t> changed_objects(const Scene& scene) {
  std::set<std::int16_t> changed;
  for (const auto& change : scene.changes) {
    for (const auto term : terms(change.atom)) changed.insert(term);
  }
  return changed;
}

/// A new variable's literals that occur, and which of them occur together.
class Descriptions {
 public:
  Descriptions(ActionExamples& examples, const RuleKey& key) {
    const Covered covered = examples.cover(key);
    std::vector<std::vector<int>> all;
    for (std::size_t i = 0; i < covered.size(); ++i) {
      const Scene& scene = examples.scenes()[covered.examples[i]];
      const Binding binding(covered.binding(i), covered.binding(i) + key.variables);
      for (const auto& one : described(scene, binding)) all.push_back(numbers(one));
      for (const auto object : changed_objects(scene)) {
        nameless_ = nameless_ || (!is_bound(binding, object) && description(scene, binding, object).empty());
      }
    }
    together_.assign(literals_.size(), std::vector<int>(literals_.size()));
    for (const auto& one : all) {
      for (const int a : one) {
        for (const int b : one) ++together_[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
      }
    }
  }

  const std::vector<LiftedLiteral>& literals() const { return literals_; }
  bool both(std::size_t a, std::size_t b) const { return together_[a][b] > 0; }
  bool first_without_second(std::size_t a, std::size_t b) const { return together_[a][b] < together_[a][a]; }
  /// An object changes of which nothing holds before.
  bool nameless() const { return nameless_; }

 private:
  /// The descriptions of all objects that are not bound; one pass over the scene's literals for all of them.
  static std::map<std::int16_t, std::vector<LiftedLiteral>> described(const Scene& scene, const Binding& binding) {
    std::map<std::int16_t, std::vector<LiftedLiteral>> found;
    const auto look_at = [&](const LiftedLiteral& ground) {
      std::vector<std::int16_t> open;
      for (const auto term : terms(ground.atom)) {
        if (!is_bound(binding, term) && !is_bound(open, term)) open.push_back(term);
      }
      for (const auto object : open) {
        Binding extended = binding;
        extended.push_back(object);
        LiftedLiteral literal = ground;
        if (lift(scene, extended, literal.atom)) found[object].push_back(literal);
      }
    };
    for (const auto& atom : scene.before) look_at({.atom = atom});
    for (const auto& [atom, value] : scene.values) {
      look_at({.atom = atom, .relation = Relation::equal, .negated = false, .value = value});
    }
    return found;
  }
  std::vector<int> numbers(const std::pair<const std::int16_t, std::vector<LiftedLiteral>>& one) {
    std::vector<int> result;
    for (const auto& literal : one.second) {
      const auto [at, fresh] = index_.try_emplace(literal, static_cast<int>(literals_.size()));
      if (fresh) literals_.push_back(literal);
      result.push_back(at->second);
    }
    return result;
  }

  std::vector<LiftedLiteral> literals_;
  std::map<LiftedLiteral, int> index_;
  std::vector<std::vector<int>> together_;
  bool nameless_ = false;
};

}  // namespace

std::vector<LiftedLiteral> lifted_literals(const Scene& scene, const std::vector<std::int16_t>& bound) {
  std::vector<LiftedLiteral> lifted;
  for (const auto& atom : scene.before) {
    LiftedLiteral literal{.atom = atom};
    if (lift(scene, bound, literal.atom)) lifted.push_back(literal);
  }
  for (const auto& [atom, value] : scene.values) {
    LiftedLiteral literal{.atom = atom, .relation = Relation::equal, .negated = false, .value = value};
    if (lift(scene, bound, literal.atom)) lifted.push_back(literal);
  }
  std::sort(lifted.begin(), lifted.end());
  return lifted;
}

bool mentions(const LiftedLiteral& literal, int variable) {
  const auto all = terms(literal.atom);
  return std::find(all.begin(), all.end(), variable) != all.end();
}

RuleKey with(const RuleKey& key, std::initializer_list<LiftedLiteral> literals, int variables) {
  RuleKey extended = key;
  extended.variables = variables;
  extended.context.insert(extended.context.end(), literals);
  return canonical(std::move(extended));
}

RuleKey without(const RuleKey& key, const LiftedLiteral& literal) {
  RuleKey reduced = key;
  std::erase(reduced.context, literal);
  return canonical(std::move(reduced));
}

void drop(const RuleKey& key, Replacements& found) {
  for (const auto& literal : key.context) found.insert({without(key, literal)});
  for (int v = key.arguments(); v < key.variables; ++v) {
    RuleKey reduced = key;
    std::erase_if(reduced.context, [&](const LiftedLiteral& literal) { return mentions(literal, v); });
    found.insert({canonical(std::move(reduced))});
  }
}

void add_references(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  if (key.references() >= examples.settings().max_references) return;
  const Descriptions known(examples, key);
  const auto& literals = known.literals();
  const int variables = key.variables + 1;
  const auto negation = [](LiftedLiteral literal) {
    literal.negated = true;
    return literal;
  };
  // A literal that says nothing of other variables seldom singles an object out, and two of them not much more often:
  // where there are many, only pairs are tried in which one links the new variable to the rule.
  constexpr std::size_t kFew = 16;
  std::vector<bool> links(literals.size(), literals.size() <= kFew);
  for (std::size_t a = 0; a < literals.size(); ++a) {
    for (int v = 0; v < key.variables; ++v) links[a] = links[a] || mentions(literals[a], v);
  }
  for (std::size_t a = 0; a < literals.size(); ++a) {
    found.insert({with(key, {literals[a]}, variables)});
    if (known.nameless()) found.insert({with(key, {negation(literals[a])}, variables)});
    for (std::size_t b = 0; b < literals.size(); ++b) {
      if (!links[a] && !links[b]) continue;
      if (b > a && known.both(a, b)) found.insert({with(key, {literals[a], literals[b]}, variables)});
      if (b == a || !known.first_without_second(a, b)) continue;
      found.insert({with(key, {literals[a], negation(literals[b])}, variables)});
      if (b > a && known.nameless()) {
        found.insert({with(key, {negation(literals[a]), negation(literals[b])}, variables)});
      }
    }
  }
}

namespace {

/// The action's arguments and those changed objects that their literals single out.
Binding nameable(const Scene& scene, int max_references) {
  Binding bound;
  for (const auto object : scene.action) {
    if (!is_bound(bound, object)) bound.push_back(object);
  }
  const auto changed = changed_objects(scene);
  for (int reference = 0; reference < max_references; ++reference) {
    // Objects that are singled out have different descriptions, so that the first one depends on no name.
    std::int16_t next = -1;
    std::vector<LiftedLiteral> first;
    for (const auto object : changed) {
      if (is_bound(bound, object)) continue;
      auto literals = description(scene, bound, object);
      if (literals.empty() || (next >= 0 && !(literals < first)) || !singles_out(scene, bound, literals)) continue;
      next = object;
      first = std::move(literals);
    }
    if (next < 0) break;
    bound.push_back(next);
  }
  return bound;
}

}  // namespace

RuleKey initial_rule(const Scene& scene, int max_references) {
  const Binding bound = nameable(scene, max_references);
  return canonical({action_terms(scene), static_cast<int>(bound.size()), lifted_literals(scene, bound)});
}

RuleKey changing_rule(const Scene& scene, int max_references) {
  const Binding bound = nameable(scene, max_references);
  RuleKey key{action_terms(scene), static_cast<int>(bound.size()), {}};
  for (auto literal : scene.changes) {
    if (!literal.negated || !lift(scene, bound, literal.atom)) continue;
    literal.negated = false;
    key.context.push_back(literal);
  }
  return canonical(std::move(key));
}

RuleKey trimmed(ActionExamples& examples, RuleKey key) {
  const auto score = [&](const RuleKey& candidate) -> double {
    const auto& fitted = examples.fit(candidate);
    if (!fitted.usable()) return -std::numeric_limits<double>::infinity();
    double rest = 0;
    examples.default_rule(fitted.covered, &rest);
    return fitted.score + rest;
  };
  double best = score(key);
  for (;;) {
    const RuleKey* better = nullptr;
    Replacements candidates;
    drop(key, candidates);
    for (const auto& candidate : candidates) {
      const double value = score(candidate.front());
      if (!(value > best + kImprovement)) continue;
      best = value;
      better = &candidate.front();
    }
    if (!better) return key;
    key = RuleKey(*better);
  }
}

std::vector<std::vector<RuleKey>> replacements(ActionExamples& examples, const RuleKey& key) {
  Replacements found;
  drop(key, found);
  add_literals(examples, key, found);
  add_references(examples, key, found);
  change_values(examples, key, found);
  change_constants(examples, key, found);
  found.erase({key});
  return {found.begin(), found.end()};
}

}  // namespace primo::rules

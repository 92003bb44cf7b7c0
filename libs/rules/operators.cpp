#include "rules/operators.h"

#include <algorithm>
#include <limits>
#include <set>

namespace primo::rules {
namespace {

constexpr double kImprovement = 1e-9;

using Replacements = std::set<std::vector<RuleKey>>;
using Binding = std::vector<std::int16_t>;

/// The atoms over bound objects only, with the objects replaced by their variables.
std::vector<LiftedLiteral> lifted_atoms(const Scene& scene, const Binding& bound) {
  std::vector<LiftedLiteral> lifted;
  for (const auto& atom : scene.before) {
    LiftedLiteral literal{atom, false};
    bool inside = true;
    for (std::size_t i = 1; i < atom.size() && atom[i] != -1 && inside; ++i) {
      const auto at = std::find(bound.begin(), bound.end(), atom[i]);
      inside = at != bound.end();
      literal.atom[i] = static_cast<std::int16_t>(at - bound.begin());
    }
    if (inside) lifted.push_back(literal);
  }
  std::sort(lifted.begin(), lifted.end());
  return lifted;
}

bool mentions(const LiftedLiteral& literal, int variable) {
  return std::find(literal.atom.begin() + 1, literal.atom.end(), variable) != literal.atom.end();
}

/// All that holds of an object beside the bound ones: the literals that mention it, as the variable after the bound
/// ones.
std::vector<LiftedLiteral> description(const Scene& scene, Binding bound, std::int16_t object) {
  bound.push_back(object);
  auto literals = lifted_atoms(scene, bound);
  std::erase_if(literals,
                [&](const LiftedLiteral& literal) { return !mentions(literal, static_cast<int>(bound.size()) - 1); });
  return literals;
}

bool is_bound(const Binding& bound, int object) { return std::find(bound.begin(), bound.end(), object) != bound.end(); }

/// Whether no other object fits the description.
bool singles_out(const Scene& scene, const Binding& bound, const std::vector<LiftedLiteral>& literals) {
  int fitting = 0;
  for (int object = 0; object < scene.objects && fitting < 2; ++object) {
    if (is_bound(bound, object)) continue;
    Binding extended = bound;
    extended.push_back(static_cast<std::int16_t>(object));
    fitting += std::all_of(literals.begin(), literals.end(), [&](const LiftedLiteral& literal) {
      return contains(scene.before, instantiate(literal.atom, extended));
    });
  }
  return fitting == 1;
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

/// Literals over the rule's variables that hold in some covered example.
void add_literals(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  std::set<LiftedLiteral> known;
  Binding binding;
  for (std::size_t i = 0; i < examples.scenes().size(); ++i) {
    if (!examples.fit(key).covered.test(i) || !examples.bind_scene(key, i, binding)) continue;
    for (const auto& literal : lifted_atoms(examples.scenes()[i], binding)) known.insert(literal);
  }
  for (auto literal : known) {
    const auto same_atom = [&](const LiftedLiteral& other) { return other.atom == literal.atom; };
    if (std::any_of(key.context.begin(), key.context.end(), same_atom)) continue;
    RuleKey positive = with(key, {literal}, key.variables);
    literal.negated = true;
    RuleKey negative = with(key, {literal}, key.variables);
    found.insert({positive});
    found.insert({negative});
    if (negative < positive) std::swap(positive, negative);
    found.insert({std::move(positive), std::move(negative)});
  }
}

void add_references(ActionExamples& examples, const RuleKey& key, Replacements& found) {
  if (key.references() >= examples.settings().max_references) return;
  std::set<std::vector<LiftedLiteral>> descriptions;
  std::set<LiftedLiteral> known;
  Binding binding;
  for (std::size_t i = 0; i < examples.scenes().size(); ++i) {
    if (!examples.fit(key).covered.test(i) || !examples.bind_scene(key, i, binding)) continue;
    const Scene& scene = examples.scenes()[i];
    for (int object = 0; object < scene.objects; ++object) {
      if (is_bound(binding, object)) continue;
      auto literals = description(scene, binding, static_cast<std::int16_t>(object));
      known.insert(literals.begin(), literals.end());
      descriptions.insert(std::move(literals));
    }
  }
  const int variables = key.variables + 1;
  for (const auto& literals : descriptions) {
    for (std::size_t a = 0; a < literals.size(); ++a) {
      found.insert({with(key, {literals[a]}, variables)});
      for (std::size_t b = a + 1; b < literals.size(); ++b) {
        found.insert({with(key, {literals[a], literals[b]}, variables)});
      }
      for (auto absent : known) {
        if (std::binary_search(literals.begin(), literals.end(), absent)) continue;
        absent.negated = true;
        found.insert({with(key, {literals[a], absent}, variables)});
      }
    }
  }
}

}  // namespace

RuleKey initial_rule(const Scene& scene, int max_references) {
  RuleKey key{.action = action_terms(scene), .variables = 0, .context = {}};
  Binding bound;
  for (const auto object : scene.action) {
    if (!is_bound(bound, object)) bound.push_back(object);
  }
  std::set<std::int16_t> changed;
  for (const auto& change : scene.changes) {
    for (std::size_t i = 1; i < change.atom.size() && change.atom[i] != -1; ++i) changed.insert(change.atom[i]);
  }
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
  key.variables = static_cast<int>(bound.size());
  key.context = lifted_atoms(scene, bound);
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
  found.erase({key});
  return {found.begin(), found.end()};
}

}  // namespace primo::rules

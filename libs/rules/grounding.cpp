#include "rules/grounding.h"

#include <algorithm>

#include "core/check.h"

namespace primo::rules {
namespace {

class Objects {
 public:
  explicit Objects(const std::vector<std::string>& names) {
    for (const auto& name : names) index(name);
  }
  std::int16_t index(const std::string& name) {
    PRIMO_CHECK(indices_.size() < INT16_MAX, "more than 32766 objects in a scene");
    return indices_.try_emplace(name, static_cast<std::int16_t>(indices_.size())).first->second;
  }
  std::int16_t find(const std::string& name) const {
    const auto at = indices_.find(name);
    return at == indices_.end() ? std::int16_t{-1} : at->second;
  }
  int size() const { return static_cast<int>(indices_.size()); }

 private:
  std::map<std::string, std::int16_t> indices_;
};

Atom make_atom(Vocabulary& vocabulary, Objects& objects, const symbols::Literal& literal) {
  PRIMO_CHECK(literal.arguments.size() <= symbols::kMaxArity, "too many arguments: " + literal.text());
  Atom atom;
  atom.fill(-1);
  atom[0] = vocabulary.intern(literal.predicate, literal.arguments.size());
  for (std::size_t i = 0; i < literal.arguments.size(); ++i) atom[i + 1] = objects.index(literal.arguments[i]);
  return atom;
}

struct Facts {
  std::vector<Atom> atoms;
  std::vector<Valued> values;
};

void add_facts(Vocabulary& vocabulary, Objects& objects, const symbols::State& state, Facts& facts) {
  for (const auto& literal : state) {
    const Atom atom = make_atom(vocabulary, objects, literal);
    if (literal.relation == Relation::none) {
      facts.atoms.push_back(atom);
    } else {
      facts.values.push_back({atom, literal.value});
    }
  }
}

void sort(Facts& facts) {
  std::sort(facts.atoms.begin(), facts.atoms.end());
  std::sort(facts.values.begin(), facts.values.end());
}

const Valued* find_value(const std::vector<Valued>& values, const Atom& atom) {
  const auto at =
      std::lower_bound(values.begin(), values.end(), atom, [](const Valued& v, const Atom& a) { return v.atom < a; });
  return at != values.end() && at->atom == atom ? &*at : nullptr;
}

std::vector<LiftedLiteral> changes_between(const Facts& before, const Facts& after) {
  std::vector<LiftedLiteral> changes;
  const auto has = [](const std::vector<Atom>& atoms, const Atom& atom) {
    return std::binary_search(atoms.begin(), atoms.end(), atom);
  };
  for (const auto& atom : after.atoms) {
    if (!has(before.atoms, atom)) changes.push_back({.atom = atom});
  }
  for (const auto& atom : before.atoms) {
    if (!has(after.atoms, atom)) changes.push_back({.atom = atom, .negated = true});
  }
  for (const auto& [atom, value] : after.values) {
    const Valued* old = find_value(before.values, atom);
    if (!old || old->value != value) changes.push_back({.atom = atom, .relation = Relation::equal, .value = value});
  }
  for (const auto& [atom, value] : before.values) {
    if (find_value(after.values, atom)) continue;
    changes.push_back({.atom = atom, .relation = Relation::equal, .negated = true, .value = value});
  }
  std::sort(changes.begin(), changes.end());
  return changes;
}

bool compare(Relation relation, std::int32_t value, std::int32_t bound) {
  return relation == Relation::equal      ? value == bound
         : relation == Relation::at_least ? value >= bound
                                          : value <= bound;
}

/// The atom with its variables and constants replaced by objects; false when a constant is not in the scene.
bool instantiate(const Scene& scene, const std::int16_t* binding, Atom& atom) {
  for (auto& term : terms(atom)) {
    if (term >= 0) {
      term = binding[term];
    } else if (const auto k = constant_index(term); k < scene.constants.size() && scene.constants[k] >= 0) {
      term = scene.constants[k];
    } else {
      return false;
    }
  }
  return true;
}

bool ground_holds(const Scene& scene, const Atom& atom, const LiftedLiteral& literal) {
  if (literal.relation == Relation::none) {
    return std::binary_search(scene.before.begin(), scene.before.end(), atom) != literal.negated;
  }
  const Valued* found = find_value(scene.values, atom);
  return (found && compare(literal.relation, found->value, literal.value)) != literal.negated;
}

}  // namespace

std::int16_t Vocabulary::intern(const std::string& name, std::size_t arity) {
  const auto [at, fresh] = indices_.try_emplace({name, arity}, static_cast<std::int16_t>(names_.size()));
  if (fresh) {
    PRIMO_CHECK(names_.size() < INT16_MAX, "more than 32766 predicates");
    names_.push_back(name);
  }
  return at->second;
}

std::vector<std::int16_t> Vocabulary::sort() {
  std::vector<std::int16_t> becomes(names_.size());
  bool moved = false;
  std::int16_t next = 0;
  for (auto& [key, index] : indices_) {
    moved = moved || index != next;
    becomes[static_cast<std::size_t>(index)] = next;
    index = next;
    names_[static_cast<std::size_t>(next++)] = key.first;
  }
  return moved ? becomes : std::vector<std::int16_t>{};
}

Scene make_scene(Vocabulary& vocabulary, const std::vector<std::string>& objects, const symbols::State& before,
                 const symbols::Literal& action, const symbols::State& after, const std::vector<std::string>& constants,
                 const symbols::State& derived) {
  Objects indices(objects);
  Scene scene;
  for (const auto& argument : action.arguments) scene.action.push_back(indices.index(argument));
  Facts old, now;
  add_facts(vocabulary, indices, before, old);
  add_facts(vocabulary, indices, after, now);
  sort(old);
  sort(now);
  scene.changes = changes_between(old, now);
  if (!derived.empty()) {
    add_facts(vocabulary, indices, derived, old);
    sort(old);
  }
  scene.before = std::move(old.atoms);
  scene.values = std::move(old.values);
  scene.objects = indices.size();
  for (const auto& name : constants) scene.constants.push_back(indices.find(name));
  scene.before.shrink_to_fit();
  scene.changes.shrink_to_fit();
  return scene;
}

bool holds(const Scene& scene, const LiftedLiteral& literal, const std::vector<std::int16_t>& binding) {
  Atom atom = literal.atom;
  if (!instantiate(scene, binding.data(), atom)) return literal.negated;
  return ground_holds(scene, atom, literal);
}

bool holds_after(const Scene& scene, const LiftedLiteral& literal, const std::int16_t* binding) {
  Atom atom = literal.atom;
  if (!instantiate(scene, binding, atom)) return literal.negated;
  const auto at = std::lower_bound(scene.changes.begin(), scene.changes.end(), atom,
                                   [](const LiftedLiteral& change, const Atom& a) { return change.atom < a; });
  if (at == scene.changes.end() || at->atom != atom) return ground_holds(scene, atom, literal);
  const bool positive =
      !at->negated && (literal.relation == Relation::none || compare(literal.relation, at->value, literal.value));
  return positive != literal.negated;
}

int count_arguments(const std::vector<std::int16_t>& action) {
  int arguments = 0;
  for (const auto term : action) arguments = std::max(arguments, term + 1);
  return arguments;
}

bool bind_action(const std::vector<std::int16_t>& action, const Scene& scene, std::vector<std::int16_t>& binding) {
  if (scene.action.size() != action.size()) return false;
  binding.assign(static_cast<std::size_t>(count_arguments(action)), -1);
  for (std::size_t i = 0; i < action.size(); ++i) {
    const auto object = scene.action[i];
    if (action[i] < 0) {
      const auto k = constant_index(action[i]);
      if (k >= scene.constants.size() || scene.constants[k] != object) return false;
      continue;
    }
    auto& bound = binding[static_cast<std::size_t>(action[i])];
    if (bound == object) continue;
    if (bound != -1 || std::find(binding.begin(), binding.end(), object) != binding.end()) return false;
    bound = object;
  }
  return true;
}

Pattern::Pattern(std::vector<std::int16_t> action, int variables, const std::vector<LiftedLiteral>& context)
    : action_(std::move(action)), arguments_(static_cast<std::size_t>(count_arguments(action_))) {
  stages_.resize(1 + static_cast<std::size_t>(variables) - arguments_);
  for (const auto& literal : context) {
    std::size_t stage = 0;
    for (const auto term : terms(literal.atom)) {
      if (term < static_cast<int>(arguments_)) continue;
      stage = std::max(stage, static_cast<std::size_t>(term) - arguments_ + 1);
    }
    stages_[stage].push_back(literal);
  }
}

int Pattern::count_bindings(const Scene& scene, std::vector<std::int16_t>& binding) const {
  std::vector<std::int16_t> trial;
  if (!bind_action(action_, scene, trial)) return 0;
  return extend(scene, trial, 0, binding);
}

int Pattern::extend(const Scene& scene, std::vector<std::int16_t>& binding, std::size_t stage,
                    std::vector<std::int16_t>& first) const {
  for (const auto& literal : stages_[stage]) {
    if (!holds(scene, literal, binding)) return 0;
  }
  if (stage + 1 == stages_.size()) {
    first = binding;
    return 1;
  }
  int found = 0;
  for (int object = 0; object < scene.objects && found < 2; ++object) {
    const auto index = static_cast<std::int16_t>(object);
    if (std::find(binding.begin(), binding.end(), index) != binding.end()) continue;
    binding.push_back(index);
    // Only the first way found is kept: a second one makes the binding void anyhow.
    found += extend(scene, binding, stage + 1, first);
    binding.pop_back();
  }
  return std::min(found, 2);
}

}  // namespace primo::rules

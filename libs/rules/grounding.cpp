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

std::vector<Atom> make_atoms(Vocabulary& vocabulary, Objects& objects, const symbols::State& state) {
  std::vector<Atom> atoms;
  atoms.reserve(state.size());
  for (const auto& literal : state) atoms.push_back(make_atom(vocabulary, objects, literal));
  std::sort(atoms.begin(), atoms.end());
  return atoms;
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

Scene make_scene(Vocabulary& vocabulary, const std::vector<std::string>& objects, const symbols::State& before,
                 const symbols::Literal& action, const symbols::State& after) {
  Objects indices(objects);
  Scene scene;
  for (const auto& argument : action.arguments) scene.action.push_back(indices.index(argument));
  scene.before = make_atoms(vocabulary, indices, before);
  scene.after = make_atoms(vocabulary, indices, after);
  scene.objects = indices.size();
  for (const auto& atom : scene.after) {
    if (!contains(scene.before, atom)) scene.changes.push_back({atom, false});
  }
  for (const auto& atom : scene.before) {
    if (!contains(scene.after, atom)) scene.changes.push_back({atom, true});
  }
  return scene;
}

int count_arguments(const std::vector<std::int16_t>& action) {
  int arguments = 0;
  for (const auto term : action) arguments = std::max(arguments, term + 1);
  return arguments;
}

Atom instantiate(const Atom& lifted, const std::vector<std::int16_t>& binding) {
  Atom atom = lifted;
  for (std::size_t i = 1; i < atom.size() && atom[i] != -1; ++i) {
    atom[i] = atom[i] >= 0 ? binding[static_cast<std::size_t>(atom[i])] : static_cast<std::int16_t>(-2 - atom[i]);
  }
  return atom;
}

bool contains(const std::vector<Atom>& sorted_atoms, const Atom& atom) {
  return std::binary_search(sorted_atoms.begin(), sorted_atoms.end(), atom);
}

Pattern::Pattern(std::vector<std::int16_t> action, int variables, const std::vector<LiftedLiteral>& context)
    : action_(std::move(action)), arguments_(static_cast<std::size_t>(count_arguments(action_))) {
  stages_.resize(1 + static_cast<std::size_t>(variables) - arguments_);
  for (const auto& literal : context) {
    std::size_t stage = 0;
    for (std::size_t i = 1; i < literal.atom.size(); ++i) {
      if (literal.atom[i] < static_cast<int>(arguments_)) continue;
      stage = std::max(stage, static_cast<std::size_t>(literal.atom[i]) - arguments_ + 1);
    }
    stages_[stage].push_back(literal);
  }
}

int Pattern::count_bindings(const Scene& scene, std::vector<std::int16_t>& binding) const {
  if (scene.action.size() != action_.size()) return 0;
  std::vector<std::int16_t> trial(arguments_, -1);
  for (std::size_t i = 0; i < action_.size(); ++i) {
    const auto object = scene.action[i];
    if (action_[i] < 0) {
      if (constant(object) != action_[i]) return 0;
      continue;
    }
    auto& bound = trial[static_cast<std::size_t>(action_[i])];
    if (bound == object) continue;
    if (bound != -1 || std::find(trial.begin(), trial.end(), object) != trial.end()) return 0;
    bound = object;
  }
  return extend(scene, trial, 0, binding);
}

int Pattern::extend(const Scene& scene, std::vector<std::int16_t>& binding, std::size_t stage,
                    std::vector<std::int16_t>& first) const {
  for (const auto& literal : stages_[stage]) {
    if (contains(scene.before, instantiate(literal.atom, binding)) == literal.negated) return 0;
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

#include "rules/experience_store.h"

#include <algorithm>

#include "core/hash.h"

namespace primo::rules {
namespace {

using symbols::Experience;

constexpr std::size_t kMaxObjects = 1000;
constexpr std::size_t kMaxPredicates = 10000;

Error data(const std::string& message) { return {Code::data, message}; }

std::uint64_t contents(const Experience& experience) {
  Experience nameless = experience;
  nameless.id.clear();
  return Hasher().add(symbols::to_json_line(nameless)).value();
}

void renumber(std::vector<Scene>& scenes, const std::vector<std::int16_t>& becomes) {
  const auto move = [&](Atom& atom) { atom[0] = becomes[static_cast<std::size_t>(atom[0])]; };
  for (auto& scene : scenes) {
    for (auto& atom : scene.before) move(atom);
    for (auto& valued : scene.values) move(valued.atom);
    for (auto& change : scene.changes) move(change.atom);
    std::sort(scene.before.begin(), scene.before.end());
    std::sort(scene.values.begin(), scene.values.end());
    std::sort(scene.changes.begin(), scene.changes.end());
  }
}

}  // namespace

Status ExperienceStore::check(const Experience& experience) const {
  PRIMO_TRY(symbols::validate(experience));
  if (experience.objects.size() > kMaxObjects) {
    return data(std::to_string(experience.objects.size()) + " objects; at most " + std::to_string(kMaxObjects) +
                " are supported");
  }
  if (vocabulary_.size() > kMaxPredicates) {
    return data("more than " + std::to_string(kMaxPredicates) + " predicates");
  }
  for (const auto& definition : background_.derived) {
    const auto& name = definition.head.predicate;
    for (const auto* state : {&experience.before, &experience.after}) {
      const auto at = state->lower_bound({name, {}});
      if (at != state->end() && at->predicate == name) {
        return data(at->text() + " is in the state, but " + name + " is defined as derived from it");
      }
    }
  }
  return success();
}

Result<bool> ExperienceStore::add(const Experience& experience, const std::string& where) {
  if (const auto status = check(experience); !status.ok()) return status.error().at(where);
  PRIMO_TRY(signatures_.add(experience, where));
  if (!experience.id.empty()) {
    const auto hash = contents(experience);
    const auto [at, fresh] = known_.try_emplace(experience.id, hash);
    if (!fresh && at->second == hash) return false;
    if (!fresh) return data(where + ": " + experience.id + " stands twice with different contents; ids must be unique");
  }
  const auto derived = symbols::derive(background_.derived, experience.objects, experience.before);
  auto& scenes = scenes_[experience.action.predicate];
  scenes.push_back(make_scene(vocabulary_, experience.objects, experience.before, experience.action, experience.after,
                              background_.constants, derived));
  for (const auto& change : scenes.back().changes) changing_.insert(change.atom[0]);
  ++size_;
  return true;
}

bool ExperienceStore::sort() {
  const bool more = changing_.size() != changing_then_;
  changing_then_ = changing_.size();
  const std::size_t before = sorted_;
  sorted_ = vocabulary_.size();
  if (before == sorted_) return more;
  const auto becomes = vocabulary_.sort();
  if (becomes.empty()) return more;
  for (auto& [action, scenes] : scenes_) renumber(scenes, becomes);
  std::set<std::int16_t> changing;
  for (const auto predicate : changing_) changing.insert(becomes[static_cast<std::size_t>(predicate)]);
  changing_ = std::move(changing);
  return true;
}

}  // namespace primo::rules

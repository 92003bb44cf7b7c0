#include "rules/coverage.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace primo::rules {
namespace {

using symbols::Literal;
using symbols::State;

Atom atom(std::int16_t predicate, std::vector<std::int16_t> arguments) {
  Atom result;
  result.fill(-1);
  result[0] = predicate;
  std::copy(arguments.begin(), arguments.end(), result.begin() + 1);
  return result;
}

/// Scenes of p(·,·), q(·) and a function f(·), with action do(·,·).
std::vector<Scene> draw_scenes(Random& random, Vocabulary& vocabulary, int scenes, std::size_t objects) {
  std::vector<Scene> all;
  for (int i = 0; i < scenes; ++i) {
    std::vector<std::string> names;
    for (std::size_t o = 0; o < 2 + random.below(objects - 1); ++o) names.push_back("o" + std::to_string(o));
    State state;
    for (const auto& x : names) {
      if (random.below(2)) state.insert({"q", {x}});
      if (random.below(2)) state.insert({"f", {x}, false, Relation::equal, static_cast<std::int32_t>(random.below(3))});
      for (const auto& y : names) {
        if (random.below(3) == 0) state.insert({"p", {x, y}});
      }
    }
    const Literal action{"do", {names[random.below(names.size())], names[random.below(names.size())]}};
    all.push_back(make_scene(vocabulary, names, state, action, state, {"o0"}));
  }
  return all;
}

RuleKey draw_rule(Random& random) {
  RuleKey key;
  key.action = {0, static_cast<std::int16_t>(random.below(3) == 0 ? 0 : 1)};
  key.variables = key.arguments() + static_cast<int>(random.below(3));
  const auto term = [&]() -> std::int16_t {
    if (random.below(6) == 0) return constant(0);
    return static_cast<std::int16_t>(random.below(static_cast<std::uint64_t>(key.variables)));
  };
  for (auto n = random.below(5); n > 0; --n) {
    const bool negated = random.below(3) == 0;
    switch (random.below(3)) {
      case 0:
        key.context.push_back({.atom = atom(0, {term(), term()}), .negated = negated});
        break;
      case 1:
        key.context.push_back({.atom = atom(1, {term()}), .negated = negated});
        break;
      default:
        key.context.push_back({.atom = atom(2, {term()}),
                               .relation = static_cast<Relation>(1 + random.below(3)),
                               .negated = negated,
                               .value = static_cast<std::int32_t>(random.below(3))});
    }
  }
  return canonical(key);
}

/// Sets of machine words against the binding of each scene by trying objects.
void compare(std::size_t objects, std::uint64_t seed, int* covered_in_all) {
  Random random(seed, "coverage", {objects});
  Vocabulary vocabulary;
  for (const auto& [name, arity] : std::vector<std::pair<std::string, std::size_t>>{{"p", 2}, {"q", 1}, {"f", 1}}) {
    vocabulary.intern(name, arity);
  }
  std::vector<Scene> scenes = draw_scenes(random, vocabulary, 40, objects);
  scenes.reserve(200);
  Coverage coverage(scenes);
  std::vector<RuleKey> keys;
  for (int r = 0; r < 60; ++r) keys.push_back(draw_rule(random));
  for (int growth = 0; growth < 3; ++growth) {
    for (const auto& key : keys) {
      const Pattern pattern(key.action, key.variables, key.context);
      const Covered covered = coverage.cover(key);
      std::size_t next = 0;
      std::vector<std::int16_t> binding;
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        if (pattern.count_bindings(scenes[i], binding) != 1) continue;
        ASSERT_LT(next, covered.size());
        ASSERT_EQ(covered.examples[next], i);
        ASSERT_EQ(std::vector<std::int16_t>(covered.binding(next), covered.binding(next) + key.variables), binding);
        ++next;
      }
      ASSERT_EQ(next, covered.size());
      *covered_in_all += static_cast<int>(next);
      const std::size_t from = scenes.size() / 2;
      EXPECT_EQ(coverage.cover(key, from).size(),
                static_cast<std::size_t>(std::count_if(covered.examples.begin(), covered.examples.end(),
                                                       [&](std::uint32_t i) { return i >= from; })));
    }
    for (auto& scene : draw_scenes(random, vocabulary, 37, objects)) scenes.push_back(std::move(scene));
    if (growth == 1) coverage.limit_memory();
  }
}

TEST(Coverage, agrees_with_trying_every_object_also_when_scenes_are_added) {
  int covered = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) compare(5, seed, &covered);
  EXPECT_GT(covered, 5000);
}

TEST(Coverage, takes_scenes_with_more_objects_than_a_word_has_bits) {
  int covered = 0;
  compare(90, 1, &covered);
  EXPECT_GT(covered, 100);
}

TEST(Canonical, renamings_of_deictic_variables_are_one_rule) {
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    Random random(3, "renaming", {trial});
    const RuleKey key = draw_rule(random);
    RuleKey renamed = key;
    const int first = key.arguments(), n = key.variables - first;
    const auto shift = random.below(static_cast<std::uint64_t>(std::max(n, 1)));
    for (auto& literal : renamed.context) {
      for (auto& term : terms(literal.atom)) {
        if (term >= first) term = static_cast<std::int16_t>(first + (term - first + static_cast<int>(shift)) % n);
      }
    }
    std::reverse(renamed.context.begin(), renamed.context.end());
    EXPECT_EQ(canonical(renamed), key);
  }
}

}  // namespace
}  // namespace primo::rules

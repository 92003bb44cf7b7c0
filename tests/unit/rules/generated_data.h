// Experiences drawn from known rules, for the tests and benchmarks of the learner.
#pragma once

#include <string>
#include <vector>

#include "core/random.h"
#include "rules/prediction.h"
#include "rules/rule.h"

namespace primo::rules::generated {

using symbols::Experience;
using symbols::Literal;
using symbols::State;

inline Literal lit(std::string predicate, std::vector<std::string> arguments = {}) {
  return {std::move(predicate), std::move(arguments), false};
}
inline Literal no(std::string predicate, std::vector<std::string> arguments = {}) {
  return {std::move(predicate), std::move(arguments), true};
}

inline std::string numbered(std::string name, std::uint64_t number) { return name.append(std::to_string(number)); }

/// Where an object stands: on another one in one case of four, or on the table and on each free object equally often,
/// as the slippery gripper's blocks.
enum class Stacking { seldom, evenly };

/// A table and some objects on it or on each other; cylinders, boxes, and with some luck one in the hand.
inline Experience make_tabletop(Random& random, int objects, Stacking stacking = Stacking::seldom) {
  Experience experience;
  experience.objects.push_back("t");
  experience.before.insert(lit("table", {"t"}));
  std::vector<std::string> standing;  // with a free top
  for (int i = 0; i < objects; ++i) {
    const std::string name = numbered("o", static_cast<std::uint64_t>(i));
    experience.objects.push_back(name);
    experience.before.insert(lit(random.below(3) == 0 ? "box" : "cylinder", {name}));
    const bool stacked = stacking == Stacking::evenly ? random.below(standing.size() + 1) > 0
                                                      : !standing.empty() && random.below(4) == 0;
    if (stacked) {
      const auto below = random.below(standing.size());
      experience.before.insert(lit("on", {name, standing[below]}));
      standing.erase(standing.begin() + static_cast<std::ptrdiff_t>(below));
    } else {
      experience.before.insert(lit("on", {name, "t"}));
    }
    standing.push_back(name);
  }
  for (const auto& name : standing) experience.before.insert(lit("clear", {name}));
  return experience;
}

/// s′ drawn from `rules`; noise and what no rule covers leave the state as it is.
inline void act(Random& random, const RuleSet& rules, Experience& experience) {
  const auto prediction = predict(rules, experience.objects, experience.before, experience.action);
  experience.after = experience.before;
  double u = random.uniform();
  for (const auto& successor : prediction.successors) {
    if (u < successor.p) {
      experience.after = successor.state;
      return;
    }
    u -= successor.p;
  }
}

inline DefaultRule nothing_happens() { return {.no_change = 1, .noise = 0}; }

/// The paper's grasp rule and a place rule with a deictic table. An object that stands on another one is not graspable.
inline RuleSet grasp_place(double grasp, double place) {
  RuleSet rules;
  rules.rules.push_back({.action = lit("grasp", {"X"}),
                         .context = {lit("on", {"X", "Y"}), lit("cylinder", {"X"}), lit("table", {"Y"})},
                         .outcomes = {{grasp, {lit("inhand", {"X"}), no("on", {"X", "Y"})}, 0}, {1 - grasp, {}, 0}}});
  rules.rules.push_back(
      {.action = lit("place", {"X", "Y"}),
       .context = {lit("inhand", {"X"}), lit("cylinder", {"X"}), lit("on", {"Y", "Z"}), lit("table", {"Z"})},
       .outcomes = {{place, {lit("on", {"X", "Y"}), no("inhand", {"X"})}, 0}, {1 - place, {}, 0}}});
  rules.defaults = {{"grasp", nothing_happens()}, {"place", nothing_happens()}};
  return rules;
}

/// A scene of four objects in which one is to be grasped, or placed on another.
inline Experience draw_grasp_place(Random& random, bool grasp, Stacking stacking = Stacking::seldom) {
  Experience experience = make_tabletop(random, 4, stacking);
  const std::string x = numbered("o", random.below(4));
  std::string y = numbered("o", random.below(4));
  if (grasp) {
    experience.action = lit("grasp", {x});
    return experience;
  }
  while (y == x) y = numbered("o", random.below(4));
  if (random.below(4) != 0) {  // x is in the hand; what stood on it now stands on the table
    std::erase_if(experience.before, [&](const Literal& l) { return l.predicate == "on" && l.arguments[0] == x; });
    State moved;
    for (const auto& l : experience.before) {
      moved.insert(l.predicate == "on" && l.arguments[1] == x ? lit("on", {l.arguments[0], "t"}) : l);
    }
    experience.before = moved;
    experience.before.insert(lit("inhand", {x}));
  }
  experience.action = lit("place", {x, y});
  return experience;
}

/// Half of the experiences are grasps, half places.
inline std::vector<Experience> grasp_place_data(const RuleSet& rules, int n, std::uint64_t seed) {
  std::vector<Experience> data;
  for (int i = 0; i < n; ++i) {
    Random random(seed, "grasp and place", {static_cast<std::uint64_t>(i)});
    Experience experience = draw_grasp_place(random, i % 2 == 0);
    experience.id = numbered("e", static_cast<std::uint64_t>(i));
    act(random, rules, experience);
    data.push_back(std::move(experience));
  }
  return data;
}

/// Slippery gripper after Kushmerick, Hanks and Weld (AIJ 76, 1995), one block: dry, paint, pickup from a table.
inline RuleSet slippery_gripper() {
  RuleSet rules;
  rules.rules.push_back(
      {.action = lit("pickup", {"X"}),
       .context = {lit("on", {"X", "T"}), lit("block", {"X"}), lit("handempty"), no("wet")},
       .outcomes = {{0.8, {lit("inhand", {"X"}), no("on", {"X", "T"}), no("handempty")}, 0}, {0.2, {}, 0}}});
  rules.rules.push_back(
      {.action = lit("pickup", {"X"}),
       .context = {lit("on", {"X", "T"}), lit("block", {"X"}), lit("handempty"), lit("wet")},
       .outcomes = {{0.5, {lit("inhand", {"X"}), no("on", {"X", "T"}), no("handempty")}, 0}, {0.5, {}, 0}}});
  rules.rules.push_back(
      {.action = lit("paint", {"X"}),
       .context = {lit("block", {"X"})},
       .outcomes = {{0.6, {lit("painted", {"X"})}, 0}, {0.1, {lit("painted", {"X"}), lit("wet")}, 0}, {0.3, {}, 0}}});
  rules.rules.push_back({.action = lit("dry"), .context = {}, .outcomes = {{0.9, {no("wet")}, 0}, {0.1, {}, 0}}});
  rules.defaults = {{"pickup", nothing_happens()}, {"paint", nothing_happens()}, {"dry", nothing_happens()}};
  return rules;
}

inline std::vector<Experience> slippery_gripper_data(const RuleSet& rules, int n, std::uint64_t seed) {
  std::vector<Experience> data;
  for (int i = 0; i < n; ++i) {
    Random random(seed, "slippery gripper", {static_cast<std::uint64_t>(i)});
    Experience experience;
    experience.id = numbered("e", static_cast<std::uint64_t>(i));
    experience.objects = {"t", "b0", "b1", "b2"};
    const auto held = random.below(5);
    for (std::uint64_t b = 0; b < 3; ++b) {
      const std::string name = numbered("b", b);
      experience.before.insert(lit("block", {name}));
      experience.before.insert(held == b ? lit("inhand", {name}) : lit("on", {name, "t"}));
      if (random.below(2)) experience.before.insert(lit("painted", {name}));
    }
    if (held > 2) experience.before.insert(lit("handempty"));
    if (random.below(2)) experience.before.insert(lit("wet"));
    const std::string block = random.below(6) == 0 ? "t" : numbered("b", random.below(3));
    const auto action = random.below(3);
    experience.action = action == 0 ? lit("pickup", {block}) : action == 1 ? lit("paint", {block}) : lit("dry");
    act(random, rules, experience);
    data.push_back(std::move(experience));
  }
  return data;
}

/// Mean total variation distance of the two rule sets' predictions on the experiences' (s, a); noise counts as one
/// further state.
inline double variational_distance(const RuleSet& a, const RuleSet& b, const std::vector<Experience>& test) {
  double sum = 0;
  for (const auto& e : test) {
    std::map<State, double> difference;
    const auto pa = predict(a, e.objects, e.before, e.action), pb = predict(b, e.objects, e.before, e.action);
    for (const auto& successor : pa.successors) difference[successor.state] += successor.p;
    for (const auto& successor : pb.successors) difference[successor.state] -= successor.p;
    double distance = std::abs(pa.noise - pb.noise);
    for (const auto& [state, d] : difference) distance += std::abs(d);
    sum += distance / 2;
  }
  return sum / static_cast<double>(test.size());
}

}  // namespace primo::rules::generated

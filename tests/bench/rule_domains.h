// Domains whose rules are known, and seeded generators of experiences from them: the slippery gripper and trucks and
// drivers after Pasula, Zettlemoyer and Kaelbling (JAIR 29, 2007), their coins (ICAPS 2004), grasp and place at chosen
// probabilities. For the benchmarks and tests of the rule learner.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "unit/rules/generated_data.h"

namespace primo::rules::domains {

using generated::lit;
using generated::no;
using generated::numbered;
using symbols::Experience;
using symbols::Literal;
using symbols::State;

enum class Use { training, test };

/// A rule set and what draws experience number i of a file of n.
struct Domain {
  std::string name;
  RuleSet truth;
  Experience (*draw)(Random& random, Use use) = nullptr;

  std::vector<Experience> data(int n, std::uint64_t seed, Use use = Use::training) const {
    std::vector<Experience> all;
    for (int i = 0; i < n; ++i) {
      Random random(seed, name + (use == Use::test ? " test" : ""), {static_cast<std::uint64_t>(i)});
      Experience experience = draw(random, use);
      experience.id = numbered("e", static_cast<std::uint64_t>(i));
      generated::act(random, truth, experience);
      all.push_back(std::move(experience));
    }
    return all;
  }
};

/// The same states with `n` further predicates, each true of every object with probability 1/2 and never changing.
inline void add_distractors(std::vector<Experience>& data, int n, std::uint64_t seed) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    Random random(seed, "distractors", {i});
    for (int d = 0; d < n; ++d) {
      for (const auto& object : data[i].objects) {
        if (random.below(2) == 0) continue;
        const Literal literal = lit(numbered("d", static_cast<std::uint64_t>(d)), {object});
        data[i].before.insert(literal);
        data[i].after.insert(literal);
      }
    }
  }
}

inline void add_defaults(RuleSet& rules) {
  for (const auto& rule : rules.rules) rules.defaults[rule.action.predicate] = generated::nothing_happens();
}

/// Blocks, a table t0 that rules reach deictically, a gripper that may be wet.
inline RuleSet gripper_rules() {
  RuleSet rules;
  const Literal up = lit("inhand", {"X"});
  const std::vector<Literal> lifted_from_block{up, no("on", {"X", "Y"}), lit("clear", {"Y"}), no("clear", {"X"}),
                                               no("inhand-nil")};
  const std::vector<Literal> falls{no("on", {"X", "Y"}), lit("on", {"X", "T"}), lit("clear", {"Y"})};
  const std::vector<Literal> lifted{up, no("on", {"X", "T"}), no("clear", {"X"}), no("inhand-nil")};
  const Literal dry = no("wet"), wet = lit("wet");
  const auto from_block = [&](const Literal& wetness, double p_up, double p_falls) {
    rules.rules.push_back({.action = lit("pickup", {"X"}),
                           .context = {lit("on", {"X", "Y"}), lit("clear", {"X"}), lit("inhand-nil"),
                                       lit("block", {"Y"}), lit("table", {"T"}), wetness},
                           .outcomes = {{p_up, lifted_from_block}, {p_falls, falls}, {1 - p_up - p_falls, {}}}});
  };
  const auto from_table = [&](const Literal& wetness, double p_up) {
    rules.rules.push_back(
        {.action = lit("pickup", {"X"}),
         .context = {lit("on", {"X", "T"}), lit("clear", {"X"}), lit("inhand-nil"), lit("table", {"T"}), wetness},
         .outcomes = {{p_up, lifted}, {1 - p_up, {}}}});
  };
  from_block(dry, 0.7, 0.2);
  from_block(wet, 0.33, 0.33);
  from_table(dry, 0.8);
  from_table(wet, 0.5);
  const std::vector<Literal> dropped{lit("on", {"X", "T"}), no("inhand", {"X"}), lit("clear", {"X"}),
                                     lit("inhand-nil")};
  rules.rules.push_back({.action = lit("puton", {"Y"}),
                         .context = {lit("clear", {"Y"}), lit("inhand", {"X"}), lit("table", {"T"})},
                         .outcomes = {{0.7,
                                       {lit("on", {"X", "Y"}), no("inhand", {"X"}), lit("clear", {"X"}),
                                        no("clear", {"Y"}), lit("inhand-nil")}},
                                      {0.2, dropped},
                                      {0.1, {}}}});
  rules.rules.push_back({.action = lit("puton", {"T"}),
                         .context = {lit("table", {"T"}), lit("inhand", {"X"})},
                         .outcomes = {{0.8, dropped}, {0.2, {}}}});
  rules.rules.push_back(
      {.action = lit("paint", {"X"}),
       .context = {lit("block", {"X"})},
       .outcomes = {{0.6, {lit("painted", {"X"})}}, {0.1, {lit("painted", {"X"}), lit("wet")}}, {0.3, {}}}});
  rules.rules.push_back({.action = lit("dry"), .context = {}, .outcomes = {{0.9, {no("wet")}}, {0.1, {}}}});
  add_defaults(rules);
  return rules;
}

/// Blocks stacked at random, 2 to 4 in training and 5 in the test; in every second state one is in the hand. Of
/// an action's ground forms any is drawn, in every second state one to which a rule applies, if there is one.
inline Experience draw_gripper(Random& random, Use use) {
  static const RuleSet rules = gripper_rules();
  static const Predictor predictor(rules);
  Experience e;
  const std::uint64_t blocks = use == Use::test ? 5 : 2 + random.below(3);
  e.objects = {"t0"};
  e.before.insert(lit("table", {"t0"}));
  std::vector<std::string> clear;
  const bool holding = random.below(2) == 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::string name = numbered("b", b);
    e.objects.push_back(name);
    e.before.insert(lit("block", {name}));
    if (random.below(3) == 0) e.before.insert(lit("painted", {name}));
    if (b + 1 == blocks && holding) {
      e.before.insert(lit("inhand", {name}));
      continue;
    }
    const auto where = random.below(clear.size() + 1);
    e.before.insert(lit("on", {name, where == clear.size() ? "t0" : clear[where]}));
    if (where < clear.size()) clear.erase(clear.begin() + static_cast<std::ptrdiff_t>(where));
    clear.push_back(name);
  }
  for (const auto& name : clear) e.before.insert(lit("clear", {name}));
  if (!holding) e.before.insert(lit("inhand-nil"));
  if (random.below(2) == 0) e.before.insert(lit("wet"));
  const char* const name = std::array{"pickup", "puton", "paint", "dry"}[random.below(4)];
  std::vector<Literal> actions, able;
  if (name == std::string("dry")) actions.push_back(lit(name));
  for (const auto& object : e.objects) {
    if (name != std::string("dry")) actions.push_back(lit(name, {object}));
  }
  for (const auto& action : actions) {
    if (predictor.covering(e.objects, e.before, action)) able.push_back(action);
  }
  const auto& from = able.empty() || random.below(2) == 0 ? actions : able;
  e.action = from[random.below(from.size())];
  return e;
}
inline Domain gripper() { return {"slippery gripper", gripper_rules(), draw_gripper}; }

/// Trucks, drivers and objects at locations of a road map.
inline RuleSet trucks_rules() {
  RuleSet rules;
  const auto at = [](const char* what, const char* where) { return lit("at", {what, where}); };
  const auto not_at = [](const char* what, const char* where) { return no("at", {what, where}); };
  rules.rules.push_back({.action = lit("load", {"O", "T"}),
                         .context = {at("T", "L"), at("O", "L"), lit("truck", {"T"}), lit("object", {"O"})},
                         .outcomes = {{0.9, {lit("in", {"O", "T"}), not_at("O", "L")}}, {0.1, {}}}});
  rules.rules.push_back({.action = lit("unload", {"O", "T"}),
                         .context = {lit("in", {"O", "T"}), at("T", "L")},
                         .outcomes = {{0.9, {at("O", "L"), no("in", {"O", "T"})}}, {0.1, {}}}});
  rules.rules.push_back(
      {.action = lit("board", {"D", "T"}),
       .context = {at("T", "L"), at("D", "L"), lit("driver", {"D"}), lit("truck", {"T"}), lit("empty", {"T"})},
       .outcomes = {{0.9, {lit("driving", {"D", "T"}), not_at("D", "L"), no("empty", {"T"})}}, {0.1, {}}}});
  rules.rules.push_back(
      {.action = lit("disembark", {"D", "T"}),
       .context = {lit("driving", {"D", "T"}), at("T", "L")},
       .outcomes = {{0.9, {at("D", "L"), lit("empty", {"T"}), no("driving", {"D", "T"})}}, {0.1, {}}}});
  rules.rules.push_back({.action = lit("drive", {"T", "M", "D"}),
                         .context = {lit("driving", {"D", "T"}), at("T", "L"), lit("road", {"L", "M"})},
                         .outcomes = {{0.9, {at("T", "M"), not_at("T", "L")}}, {0.1, {}}}});
  rules.rules.push_back({.action = lit("walk", {"D", "M"}),
                         .context = {lit("driver", {"D"}), at("D", "L"), lit("path", {"L", "M"})},
                         .outcomes = {{0.9, {at("D", "M"), not_at("D", "L")}}, {0.1, {}}}});
  add_defaults(rules);
  return rules;
}

inline Experience draw_trucks(Random& random, Use use) {
  Experience e;
  const std::uint64_t n = use == Use::test ? 3 : 2;
  std::vector<std::string> places, trucks, drivers, packages;
  const auto make = [&](std::vector<std::string>& list, const char* name, const char* kind, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      list.push_back(numbered(name, i));
      e.objects.push_back(list.back());
      e.before.insert(lit(kind, {list.back()}));
    }
  };
  make(places, "l", "location", n + 1);
  make(trucks, "t", "truck", n);
  make(drivers, "d", "driver", n);
  make(packages, "o", "object", n);
  const auto any = [&](const std::vector<std::string>& list) { return list[random.below(list.size())]; };
  for (const auto& from : places) {
    for (const auto& to : places) {
      if (from == to) continue;
      if (random.below(2) == 0) e.before.insert(lit("road", {from, to}));
      if (random.below(2) == 0) e.before.insert(lit("path", {from, to}));
    }
  }
  std::set<std::string> empty(trucks.begin(), trucks.end());
  for (const auto& t : trucks) e.before.insert(lit("at", {t, any(places)}));
  for (const auto& d : drivers) {
    const std::string t = any(trucks);
    if (random.below(2) == 0 && empty.erase(t)) {
      e.before.insert(lit("driving", {d, t}));
    } else {
      e.before.insert(lit("at", {d, any(places)}));
    }
  }
  for (const auto& t : empty) e.before.insert(lit("empty", {t}));
  for (const auto& o : packages) {
    e.before.insert(random.below(2) == 0 ? lit("in", {o, any(trucks)}) : lit("at", {o, any(places)}));
  }
  switch (random.below(6)) {
    case 0:
      e.action = lit("load", {any(packages), any(trucks)});
      break;
    case 1:
      e.action = lit("unload", {any(packages), any(trucks)});
      break;
    case 2:
      e.action = lit("board", {any(drivers), any(trucks)});
      break;
    case 3:
      e.action = lit("disembark", {any(drivers), any(trucks)});
      break;
    case 4:
      e.action = lit("drive", {any(trucks), any(places), any(drivers)});
      break;
    default:
      e.action = lit("walk", {any(drivers), any(places)});
  }
  return e;
}
inline Domain trucks() { return {"trucks and drivers", trucks_rules(), draw_trucks}; }

/// Four coins: flip-coupled turns all to heads or all to tails, flip-one a coin to either side.
inline RuleSet coins_rules() {
  RuleSet rules;
  const auto all = [](bool heads) {
    std::vector<Literal> literals;
    for (const char* coin : {"A", "B", "C", "D"}) literals.push_back({"heads", {coin}, !heads});
    return literals;
  };
  rules.rules = {{.action = lit("flip-coupled", {"A", "B", "C", "D"}),
                  .context = {},
                  .outcomes = {{0.5, all(true)}, {0.5, all(false)}}},
                 {.action = lit("flip", {"X"}),
                  .context = {},
                  .outcomes = {{0.5, {lit("heads", {"X"})}}, {0.5, {no("heads", {"X"})}}}}};
  add_defaults(rules);
  return rules;
}
inline Experience draw_coins(Random& random, Use) {
  Experience e;
  for (std::uint64_t c = 0; c < 4; ++c) {
    e.objects.push_back(numbered("c", c));
    if (random.below(2) == 0) e.before.insert(lit("heads", {e.objects.back()}));
  }
  e.action = random.below(2) == 0 ? lit("flip-coupled", e.objects) : lit("flip", {e.objects[random.below(4)]});
  return e;
}
inline Domain coins() { return {"coins", coins_rules(), draw_coins}; }

inline Experience draw_grasp_place(Random& random, Use) {
  return generated::draw_grasp_place(random, random.below(2) == 0);
}
inline Domain grasp_place(double grasp, double place) {
  return {"grasp and place", generated::grasp_place(grasp, place), draw_grasp_place};
}

/// The same with stacks as frequent as the slippery gripper's: that an object to place on must stand on the table
/// itself shows only where one stands on another.
inline Experience draw_stacked_grasp_place(Random& random, Use) {
  return generated::draw_grasp_place(random, random.below(2) == 0, generated::Stacking::evenly);
}
inline Domain stacked_grasp_place(double grasp, double place) {
  return {"grasp and place, stacked", generated::grasp_place(grasp, place), draw_stacked_grasp_place};
}

}  // namespace primo::rules::domains

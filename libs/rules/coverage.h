// Which examples a rule covers, and how its variables bind there: by sets of objects in machine words, one for each
// literal and example, which are remembered. The search asks for thousands of rules made of the same literals.
#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "rules/bits.h"
#include "rules/rule_key.h"

namespace primo::rules {

/// Covered examples and their bindings (variable → object), `variables` numbers each.
struct Covered {
  std::vector<std::uint32_t> examples;
  std::vector<std::int16_t> bindings;
  int variables = 0;

  std::size_t size() const { return examples.size(); }
  const std::int16_t* binding(std::size_t i) const { return bindings.data() + i * static_cast<std::size_t>(variables); }
};

class Coverage {
 public:
  /// The scenes may become more, but those that are there must not change.
  explicit Coverage(const std::vector<Scene>& scenes) : scenes_(scenes) {}

  /// The examples from number `begin` on that the rule covers: exactly one binding makes its context hold.
  Covered cover(const RuleKey& key, std::size_t begin = 0);

  /// Forgets what is remembered if that has become large; between two calls of cover() only.
  void limit_memory();

 private:
  /// What is known of one form of the action: which scenes have it, and the objects its variables are.
  struct Form {
    std::vector<std::int16_t> action;
    std::size_t arguments = 0, seen = 0;
    Bits match;
    std::vector<std::int16_t> bound;  // `arguments` numbers a scene
    std::vector<std::uint64_t> free;  // objects that are no arguments
    struct Facts {
      Bits bits;
      std::size_t seen = 0;
    };
    std::unordered_map<LiftedLiteral, Facts, LiteralHash> facts;                       // over arguments only
    std::unordered_map<LiftedLiteral, std::vector<std::uint64_t>, LiteralHash> unary;  // and one deictic variable
    std::unordered_map<LiftedLiteral, std::vector<std::uint64_t>, LiteralHash> pairs;  // and two: a set for each first
  };
  struct Plan;

  Form& form(const std::vector<std::int16_t>& action);
  void extend_offsets();
  const Bits& facts(Form& form, const LiftedLiteral& literal);
  const std::vector<std::uint64_t>& unary(Form& form, const LiftedLiteral& literal);
  const std::vector<std::uint64_t>& pairs(Form& form, const LiftedLiteral& literal);
  Plan plan(Form& form, const RuleKey& key);
  /// The number of bindings, up to 2; the first in `binding`.
  int bind(const Plan& plan, std::size_t scene, std::size_t variable, std::uint64_t free,
           std::vector<std::int16_t>& trial, std::int16_t* binding) const;
  std::vector<std::int16_t> arguments(const Form& form, std::size_t scene) const;
  Covered cover_wide(const RuleKey& key, std::size_t begin) const;

  const std::vector<Scene>& scenes_;
  std::map<std::vector<std::int16_t>, Form> forms_;
  std::vector<std::size_t> offsets_{0};  // Σ objects of the scenes before
  bool wide_ = false;                    // a scene has more objects than a word has bits
  std::size_t bytes_ = 0;
};

}  // namespace primo::rules

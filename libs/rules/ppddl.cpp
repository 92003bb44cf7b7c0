#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <set>

#include "rules/export.h"

namespace primo::rules {
namespace {

using symbols::Definition;
using symbols::Formula;
using symbols::is_variable;
using symbols::Literal;
using symbols::Relation;

Error impossible(const std::string& what) { return {Code::failed, "PPDDL cannot say " + what}; }

std::string number(double p) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", p);
  return text;
}

std::string joined(const std::string& head, const std::vector<std::string>& parts) {
  if (parts.size() == 1) return parts.front();
  std::string text = "(" + head;
  for (const auto& part : parts) text += " " + part;
  return text + ")";
}
std::string all_of(const std::vector<std::string>& parts) { return joined("and", parts); }

/// Names as PPDDL has them: without case, of letters, digits, - and _ only.
class Names {
 public:
  std::string operator()(const std::string& name) {
    std::string text;
    for (const char c : name) {
      const bool kept = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
      text += kept ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : '_';
    }
    if (std::isdigit(static_cast<unsigned char>(text.front()))) text = "n" + text;
    const auto [at, fresh] = given_.try_emplace(text, name);
    if (!fresh && at->second != name) clash_ = at->second + " and " + name;
    return text;
  }
  const std::string& clash() const { return clash_; }

 private:
  std::map<std::string, std::string> given_;
  std::string clash_;
};

class Writer {
 public:
  Writer(const RuleSet& rules, const PpddlOptions& options) : rules_(rules), options_(options) {}

  Result<Ppddl> run() {
    std::string axioms, actions;
    for (const auto& definition : rules_.derived) {
      PRIMO_ASSIGN(const std::string axiom, write(definition));
      axioms += axiom;
    }
    std::map<std::string, std::vector<const Rule*>> by_action;
    for (const auto& rule : rules_.rules) by_action[rule.action.predicate].push_back(&rule);
    for (const auto& [name, rules] : by_action) {
      PRIMO_ASSIGN(const std::string action, write(name, rules));
      actions += action;
    }
    for (const auto* names : {&names_, &variables_, &objects_, &action_names_}) {
      if (names->clash().empty()) continue;
      return Error{Code::config, names->clash() + " would have one name in PPDDL; rename one of them"};
    }
    std::string text = "; From NID rules. Noise becomes " + std::string(dead_end() ? "a dead end" : "no change") +
                       "; it has at most probability " + number(noise_) + " where a rule covers.\n(define (domain " +
                       Names()(options_.domain) + ")\n  (:requirements :adl :probabilistic-effects" +
                       (functions_.empty() ? "" : " :fluents") +
                       (rules_.derived.empty() ? "" : " :derived-predicates") + ")\n";
    if (!constants_.empty()) {
      text += "  (:constants";
      for (const auto& constant : constants_) text += " " + constant;
      text += ")\n";
    }
    text += "  (:predicates" + declared(predicates_) + (dead_end() ? " (dead-end)" : "") + ")\n";
    if (!functions_.empty()) text += "  (:functions" + declared(functions_) + ")\n";
    return Ppddl{text + axioms + actions + ")\n", noise_};
  }

 private:
  bool dead_end() const { return options_.noise == PpddlOptions::Noise::dead_end; }

  static std::string declared(const std::map<std::string, std::size_t>& names) {
    std::string text;
    for (const auto& [name, arity] : names) {
      text += " (" + name;
      for (std::size_t i = 0; i < arity; ++i) text += " ?a" + std::to_string(i);
      text += ")";
    }
    return text;
  }

  std::string term(const std::string& name, const std::string& mark = "") {
    if (is_variable(name)) return "?" + variables_(name) + mark;
    const std::string constant = objects_(name);
    constants_.insert(constant);
    return constant;
  }

  /// The literal without its negation and value. `mark` is put behind its variables, but not those of the action.
  std::string atom(const Literal& literal, const std::set<std::string>& bound = {}, const std::string& mark = "") {
    std::string text = "(" + names_(literal.predicate);
    for (const auto& argument : literal.arguments) {
      text += " " + term(argument, is_variable(argument) && !bound.contains(argument) ? mark : "");
    }
    auto& known = literal.relation == Relation::none ? predicates_ : functions_;
    known[names_(literal.predicate)] = literal.arguments.size();
    return text + ")";
  }

  std::string condition(const Literal& literal, const std::set<std::string>& bound = {}, const std::string& mark = "") {
    std::string text = atom(literal, bound, mark);
    if (literal.relation != Relation::none) {
      const char* const sign = literal.relation == Relation::equal      ? "="
                               : literal.relation == Relation::at_least ? ">="
                                                                        : "<=";
      text = "(" + std::string(sign) + " " + text + " " + std::to_string(literal.value) + ")";
    }
    return literal.negated ? "(not " + text + ")" : text;
  }

  Result<std::string> effect(const Literal& literal) {
    if (literal.relation == Relation::none) return condition(literal);
    if (literal.negated) return impossible("that " + literal.predicate + " loses its value");
    return "(assign " + atom(literal) + " " + std::to_string(literal.value) + ")";
  }

  // --- derived predicates -------------------------------------------------------------------------------------------

  static std::vector<std::string> variables_of(const std::vector<std::string>& terms) {
    std::vector<std::string> variables;
    for (const auto& term : terms) {
      if (is_variable(term) && std::find(variables.begin(), variables.end(), term) == variables.end()) {
        variables.push_back(term);
      }
    }
    return variables;
  }

  /// That each variable is another object than those before it and than the others.
  std::vector<std::string> different(const std::vector<std::string>& variables, const std::vector<std::string>& others,
                                     const std::string& mark = "") {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      for (const auto& other : others)
        parts.push_back("(not (= " + term(variables[i], mark) + " " + term(other) + "))");
      for (std::size_t j = 0; j < i; ++j) {
        parts.push_back("(not (= " + term(variables[i], mark) + " " + term(variables[j], mark) + "))");
      }
    }
    return parts;
  }

  std::string list(const std::vector<std::string>& variables, const std::string& mark = "") {
    std::string text;
    for (const auto& variable : variables) text += (text.empty() ? "" : " ") + term(variable, mark);
    return text;
  }

  std::string write(const Formula& formula, std::vector<std::string> bound) {
    std::string text;
    if (formula.kind == Formula::Kind::literal) {
      text = condition(formula.literal);
    } else if (formula.kind == Formula::Kind::conjunction) {
      std::vector<std::string> parts;
      for (const auto& part : formula.parts) parts.push_back(write(part, bound));
      text = all_of(parts);
    } else {
      const bool all = formula.kind == Formula::Kind::forall;
      auto parts = different(formula.variables, bound);
      bound.insert(bound.end(), formula.variables.begin(), formula.variables.end());
      const std::string inner = write(formula.parts.front(), bound);
      const std::string head = "(" + std::string(all ? "forall" : "exists") + " (" + list(formula.variables) + ") ";
      if (all && !parts.empty()) {
        text = head + "(imply " + all_of(parts) + " " + inner + "))";
      } else {
        parts.push_back(inner);
        text = head + all_of(parts) + ")";
      }
    }
    return formula.negated ? "(not " + text + ")" : text;
  }

  Result<std::string> write(const Definition& definition) {
    const Literal& head = definition.head;
    if (definition.kind == Definition::Kind::count) return impossible("the count " + definition.text());
    auto parts = different(head.arguments, {});
    if (definition.kind == Definition::Kind::formula) {
      parts.push_back(write(definition.body, head.arguments));
    } else {
      const std::string x = head.arguments[0], y = head.arguments[1], between = "Between";
      const auto step = [&](const std::string& to) {
        Literal literal = definition.body.literal;
        for (auto& argument : literal.arguments) argument = argument == y ? to : argument;
        return condition(literal);
      };
      parts.push_back("(or " + step(y) + " (exists (" + term(between) + ") (and " + step(between) + " " +
                      condition({head.predicate, {between, y}}) + ")))");
    }
    return "  (:derived " + condition(head) + "\n    " + all_of(parts) + ")\n";
  }

  // --- actions ------------------------------------------------------------------------------------------------------

  static std::vector<std::string> deictic(const Rule& rule) {
    std::vector<std::string> found;
    for (const auto& literal : rule.context) {
      for (const auto& variable : variables_of(literal.arguments)) {
        const auto& arguments = rule.action.arguments;
        if (std::find(arguments.begin(), arguments.end(), variable) == arguments.end() &&
            std::find(found.begin(), found.end(), variable) == found.end()) {
          found.push_back(variable);
        }
      }
    }
    return found;
  }

  /// The context over deictic variables marked so, with all variables different.
  std::vector<std::string> context(const Rule& rule, const std::vector<std::string>& arguments,
                                   const std::string& mark) {
    auto parts = different(deictic(rule), arguments, mark);
    for (const auto& literal : rule.context) {
      parts.push_back(condition(literal, {arguments.begin(), arguments.end()}, mark));
    }
    return parts;
  }

  /// That the rule covers: the action's form, and exactly one binding.
  std::string covers(const Rule& rule, const std::vector<std::string>& arguments) {
    auto parts = different(variables_of(arguments), {});
    const auto unknown = deictic(rule);
    if (unknown.empty()) {
      for (auto& part : context(rule, arguments, "")) parts.push_back(std::move(part));
      return all_of(parts);
    }
    std::vector<std::string> equal, one = context(rule, arguments, "");
    for (const auto& variable : unknown) equal.push_back("(= " + term(variable) + " " + term(variable, "--2") + ")");
    one.push_back("(forall (" + list(unknown, "--2") + ") (imply " + all_of(context(rule, arguments, "--2")) + " " +
                  all_of(equal) + "))");
    parts.push_back("(exists (" + list(unknown) + ") " + all_of(one) + ")");
    return all_of(parts);
  }

  Result<std::string> effects(const Rule& rule, const std::vector<Literal>& literals) {
    std::vector<std::string> plain, quantified;
    for (const auto& literal : literals) {
      PRIMO_ASSIGN(const std::string text, effect(literal));
      plain.push_back(text);
    }
    const auto unknown = deictic(rule);
    if (plain.empty() || unknown.empty()) return all_of(plain);
    const auto variables = variables_of(rule.action.arguments);
    return "(forall (" + list(unknown) + ") (when " + all_of(context(rule, variables, "")) + " " + all_of(plain) + "))";
  }

  /// Shared literals, then the choice.
  Result<std::string> outcomes(const Rule& rule) {
    const bool certain = rule.noise <= 0 && !rule.outcomes.empty();
    std::vector<Literal> shared;
    if (certain) shared = rule.outcomes.front().literals;
    std::erase_if(shared, [&](const Literal& literal) {
      return std::any_of(rule.outcomes.begin(), rule.outcomes.end(), [&](const RuleOutcome& outcome) {
        return std::find(outcome.literals.begin(), outcome.literals.end(), literal) == outcome.literals.end();
      });
    });
    std::vector<std::string> parts;
    if (!shared.empty()) {
      PRIMO_ASSIGN(const std::string text, effects(rule, shared));
      parts.push_back(text);
    }
    std::string choice;
    for (const auto& outcome : rule.outcomes) {
      auto rest = outcome.literals;
      std::erase_if(rest, [&](const Literal& l) { return std::find(shared.begin(), shared.end(), l) != shared.end(); });
      if (rest.empty() || !(outcome.p > 0)) continue;
      PRIMO_ASSIGN(const std::string text, effects(rule, rest));
      choice += "\n        " + number(outcome.p) + " " + text;
    }
    if (dead_end() && rule.noise > 0) choice += "\n        " + number(rule.noise) + " (dead-end)";
    if (!choice.empty()) parts.push_back("(probabilistic" + choice + ")");
    return parts.empty() ? std::string("(and)") : all_of(parts);
  }

  /// The rule with the action's parameters in place of its own names for them; equal names become conditions.
  struct Renamed {
    Rule rule;
    std::vector<std::string> conditions;
  };
  Renamed with_parameters(Rule rule, const std::vector<std::string>& parameters) {
    Renamed renamed{std::move(rule), {}};
    Binding names;
    const auto arguments = renamed.rule.action.arguments;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      const auto fresh = is_variable(arguments[i]) && names.emplace(arguments[i], parameters[i]).second;
      if (fresh) continue;
      const std::string other = is_variable(arguments[i]) ? names.at(arguments[i]) : arguments[i];
      renamed.conditions.push_back("(= " + term(parameters[i]) + " " + term(other) + ")");
    }
    const auto rename = [&](std::vector<Literal>& literals) {
      for (auto& literal : literals) {
        for (auto& argument : literal.arguments) {
          if (const auto at = names.find(argument); at != names.end()) argument = at->second;
        }
      }
    };
    rename(renamed.rule.context);
    for (auto& outcome : renamed.rule.outcomes) rename(outcome.literals);
    for (auto& argument : renamed.rule.action.arguments) {
      if (const auto at = names.find(argument); at != names.end()) argument = at->second;
    }
    return renamed;
  }
  using Binding = std::map<std::string, std::string>;

  Result<std::string> write(const std::string& action, const std::vector<const Rule*>& rules) {
    std::string prefix = "Arg";
    const auto taken = [&](const std::string& variable) { return variable.starts_with(prefix); };
    for (const auto* rule : rules) {
      const auto variables = deictic(*rule);
      while (std::any_of(variables.begin(), variables.end(), taken)) prefix += "s";
    }
    std::vector<std::string> parameters;
    for (std::size_t i = 0; i < rules.front()->action.arguments.size(); ++i) {
      parameters.push_back(prefix + std::to_string(i + 1));
    }
    std::vector<std::string> conditions, branches;
    std::string comments;
    for (const auto* rule : rules) {
      const auto renamed = with_parameters(*rule, parameters);
      auto parts = renamed.conditions;
      parts.push_back(covers(renamed.rule, renamed.rule.action.arguments));
      conditions.push_back(all_of(parts));
      PRIMO_ASSIGN(const std::string text, outcomes(renamed.rule));
      branches.push_back(text);
      noise_ = std::max(noise_, rule->noise);
      if (rule->noise > 0)
        comments += "  ; rule " + std::to_string(branches.size()) + ": noise " + number(rule->noise) + "\n";
    }
    std::string text = comments + "  (:action " + action_names_(action) + "\n    :parameters (" + list(parameters) +
                       ")\n    :precondition " + (dead_end() ? "(not (dead-end))" : "(and)") + "\n    :effect (and";
    std::vector<std::string> none;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      std::vector<std::string> alone{conditions[i]};
      for (std::size_t j = 0; j < rules.size(); ++j) {
        if (j != i) alone.push_back("(not " + conditions[j] + ")");
      }
      text += "\n      (when " + all_of(alone) + "\n        " + branches[i] + ")";
      none.push_back("(not " + all_of(alone) + ")");
    }
    const auto fallback = rules_.defaults.find(action);
    const double lost = fallback == rules_.defaults.end() ? 1 : fallback->second.noise;
    if (dead_end() && lost > 0) {
      text += "\n      (when " + all_of(none) + " (probabilistic " + number(lost) + " (dead-end)))";
    }
    return text + "))\n";
  }

  const RuleSet& rules_;
  PpddlOptions options_;
  Names names_, variables_, objects_, action_names_;
  std::set<std::string> constants_;
  std::map<std::string, std::size_t> predicates_, functions_;
  double noise_ = 0;
};

}  // namespace

Result<Ppddl> to_ppddl(const RuleSet& rules, const PpddlOptions& options) { return Writer(rules, options).run(); }

}  // namespace primo::rules

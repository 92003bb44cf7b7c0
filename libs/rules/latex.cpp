#include <cstdio>

#include "rules/export.h"

namespace primo::rules {
namespace {

std::string number(double p) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", p);
  return text;
}

std::string name(const std::string& raw) {
  std::string text = "\\mathsf{";
  for (const char c : raw)
    text += c == '_' ? std::string("\\_") : c == '-' ? std::string("\\text{-}") : std::string(1, c);
  return text + "}";
}

std::string term(const std::string& raw) {
  if (!symbols::is_variable(raw)) return name(raw);
  return raw.size() == 1 ? raw : "\\mathit{" + name(raw).substr(8);
}

std::string formula(const symbols::Literal& literal) {
  using symbols::Relation;
  const bool unequal = literal.negated && literal.relation == Relation::equal;
  std::string text = literal.negated && !unequal ? "\\neg " : "";
  text += name(literal.predicate);
  if (!literal.arguments.empty()) {
    text += "(";
    for (std::size_t i = 0; i < literal.arguments.size(); ++i) text += (i ? "," : "") + term(literal.arguments[i]);
    text += ")";
  }
  if (literal.relation == Relation::none) return text;
  text += unequal                                  ? " \\neq "
          : literal.relation == Relation::equal    ? " = "
          : literal.relation == Relation::at_least ? " \\geq "
                                                   : " \\leq ";
  return text + std::to_string(literal.value);
}

std::string formulas(const std::vector<symbols::Literal>& literals) {
  std::string text;
  for (const auto& literal : literals) text += (text.empty() ? "" : ",\\ ") + formula(literal);
  return text;
}

}  // namespace

std::string to_latex(const RuleSet& rules) {
  std::string text;
  for (const auto& rule : rules.rules) {
    text += "\\[\n  " + formula(rule.action) + ":\\ " + formulas(rule.context) + "\\ \\rightarrow\\ \\begin{cases}\n";
    for (const auto& outcome : rule.outcomes) {
      const std::string what = outcome.literals.empty() ? "\\text{no change}" : formulas(outcome.literals);
      text += "    " + number(outcome.p) + " & " + what + " \\\\\n";
    }
    text += "    " + number(rule.noise) + " & \\text{noise}\n  \\end{cases}\n\\]\n";
  }
  for (const auto& [action, rule] : rules.defaults) {
    text += "\\[\n  " + name(action) + "\\text{, otherwise}\\ \\rightarrow\\ \\begin{cases}\n    " +
            number(rule.no_change) + " & \\text{no change} \\\\\n    " + number(rule.noise) +
            " & \\text{noise}\n  \\end{cases}\n\\]\n";
  }
  return text;
}

}  // namespace primo::rules

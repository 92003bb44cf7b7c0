// Definitions of derived predicates as text: a recursive-descent parser and its inverse.
#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

#include "symbols/derived.h"
#include "symbols/literal_json.h"

namespace primo::symbols {
namespace {

constexpr int kMaxDepth = 20;
constexpr std::size_t kMaxLineBytes = 10000;
constexpr std::size_t kMaxVariables = 8;

using Kind = Formula::Kind;

class Parser {
 public:
  explicit Parser(const std::string& text) : text_(text) {}

  Result<Definition> definition() {
    Definition definition;
    PRIMO_ASSIGN(definition.head, literal());
    if (!take(":=")) return wrong("':=' after the name that is defined");
    if (take_word("closure")) {
      definition.kind = Definition::Kind::closure;
      PRIMO_ASSIGN(definition.body.literal, literal());
    } else if (take_word("count")) {
      definition.kind = Definition::Kind::count;
      definition.head.relation = Relation::equal;
      PRIMO_ASSIGN(definition.counted, variables());
      PRIMO_ASSIGN(definition.body, conjunction(0));
    } else {
      PRIMO_ASSIGN(definition.body, conjunction(0));
    }
    space();
    if (at_ < text_.size()) return wrong("the end of the line or 'and'");
    return definition;
  }

 private:
  Error wrong(const std::string& expected) const {
    return {Code::data, "character " + std::to_string(at_ + 1) + ": expected " + expected};
  }
  void space() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
  }
  bool take(const std::string& token) {
    space();
    if (text_.compare(at_, token.size(), token) != 0) return false;
    at_ += token.size();
    return true;
  }
  static bool in_name(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
  }
  std::string peek_word() {
    space();
    std::size_t end = at_;
    while (end < text_.size() && in_name(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }
  bool take_word(const std::string& word) {
    if (peek_word() != word) return false;
    at_ += word.size();
    return true;
  }

  Result<std::string> name(const std::string& what) {
    static const std::set<std::string> kReserved{"not", "and", "exists", "forall", "closure", "count"};
    const std::string word = peek_word();
    if (!is_name(word) || kReserved.contains(word)) return wrong(what);
    at_ += word.size();
    return word;
  }

  Result<std::vector<std::string>> variables() {
    std::vector<std::string> names;
    do {
      PRIMO_ASSIGN(const std::string variable, name("a variable"));
      if (!is_variable(variable)) return wrong("a variable, which begins with a capital, before this");
      names.push_back(variable);
    } while (take(","));
    if (!take(":")) return wrong("':' after the variables");
    return names;
  }

  Result<Literal> literal() {
    Literal result;
    PRIMO_ASSIGN(result.predicate, name("the name of a predicate"));
    if (take("(") && !take(")")) {
      do {
        PRIMO_ASSIGN(std::string term, name("a variable or an object"));
        result.arguments.push_back(std::move(term));
      } while (take(","));
      if (!take(")")) return wrong("',' or ')' after an argument");
    }
    if (result.arguments.size() > kMaxArity) return wrong("at most " + std::to_string(kMaxArity) + " arguments");
    return result;
  }

  Result<std::int32_t> number() {
    space();
    const std::size_t begin = at_;
    if (at_ < text_.size() && text_[at_] == '-') ++at_;
    while (at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_]))) ++at_;
    const std::string digits = text_.substr(begin, at_ - begin);
    if (digits.empty() || digits == "-" || digits.size() > 10) return wrong("a whole number from -1e9 to 1e9");
    const long long value = std::stoll(digits);
    if (value < -1000000000 || value > 1000000000) return wrong("a whole number from -1e9 to 1e9");
    return static_cast<std::int32_t>(value);
  }

  Result<Formula> comparison() {
    Formula formula;
    PRIMO_ASSIGN(formula.literal, literal());
    if (take("!=")) {
      formula.literal.relation = Relation::equal;
      formula.negated = true;
    } else if (take(">=")) {
      formula.literal.relation = Relation::at_least;
    } else if (take("<=")) {
      formula.literal.relation = Relation::at_most;
    } else if (take("=")) {
      formula.literal.relation = Relation::equal;
    } else {
      return formula;
    }
    PRIMO_ASSIGN(formula.literal.value, number());
    return formula;
  }

  Result<Formula> item(int depth) {
    if (depth > kMaxDepth) return wrong("less nesting: at most " + std::to_string(kMaxDepth) + " levels");
    if (take_word("not")) {
      PRIMO_ASSIGN(Formula formula, item(depth + 1));
      formula.negated = !formula.negated;
      return formula;
    }
    for (const bool all : {false, true}) {
      if (!take_word(all ? "forall" : "exists")) continue;
      Formula formula{.kind = all ? Kind::forall : Kind::exists};
      PRIMO_ASSIGN(formula.variables, variables());
      PRIMO_ASSIGN(Formula part, conjunction(depth + 1));
      formula.parts.push_back(std::move(part));
      return formula;
    }
    if (!take("(")) return comparison();
    PRIMO_ASSIGN(Formula formula, conjunction(depth + 1));
    if (!take(")")) return wrong("')'");
    return formula;
  }

  Result<Formula> conjunction(int depth) {
    Formula all{.kind = Kind::conjunction};
    do {
      PRIMO_ASSIGN(Formula part, item(depth));
      all.parts.push_back(std::move(part));
    } while (take_word("and"));
    if (all.parts.size() == 1) return Formula(all.parts.front());
    return all;
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

std::string text_of(const Formula& formula) {
  if (formula.kind == Kind::literal) {
    std::string text = formula.negated ? "not " : "";
    text += Literal{formula.literal.predicate, formula.literal.arguments}.text();
    const Relation relation = formula.literal.relation;
    if (relation == Relation::none) return text;
    text += relation == Relation::equal ? " = " : relation == Relation::at_least ? " >= " : " <= ";
    return text + std::to_string(formula.literal.value);
  }
  std::string text;
  for (const auto& part : formula.parts) {
    const bool plain = part.kind == Kind::literal;
    text += (text.empty() ? "" : " and ") + (plain ? text_of(part) : "(" + text_of(part) + ")");
  }
  if (formula.kind == Kind::conjunction) return formula.negated ? "not (" + text + ")" : text;
  const std::string quantifier = formula.kind == Kind::exists ? "exists " : "forall ";
  return (formula.negated ? "not " : "") + quantifier + joined(formula.variables) + ": " + text;
}

/// Every variable is the head's, counted or quantified, once; the head's literal is as it must be.
Status check_variables(const Formula& formula, std::set<std::string> bound) {
  const auto data = [](const std::string& message) { return Error{Code::data, message}; };
  for (const auto& variable : formula.variables) {
    if (!bound.insert(variable).second) return data("the variable " + variable + " is bound twice");
  }
  if (bound.size() > kMaxVariables) return data("more than " + std::to_string(kMaxVariables) + " variables");
  for (const auto& term : formula.literal.arguments) {
    if (is_variable(term) && !bound.contains(term)) return data("the variable " + term + " is bound nowhere");
  }
  for (const auto& part : formula.parts) PRIMO_TRY(check_variables(part, bound));
  return success();
}

Status check(const Definition& definition) {
  const auto data = [](const std::string& message) { return Error{Code::data, message}; };
  const auto& head = definition.head;
  if (head.arguments.size() > kMaxDerivedArity) {
    return data(head.predicate + " has more than " + std::to_string(kMaxDerivedArity) + " arguments");
  }
  std::set<std::string> bound;
  for (const auto& term : head.arguments) {
    if (!is_variable(term)) return data("the argument " + term + " of what is defined is no variable");
    if (!bound.insert(term).second) return data("the argument " + term + " stands twice");
  }
  for (const auto& variable : definition.counted) {
    if (!bound.insert(variable).second) return data("the variable " + variable + " is bound twice");
  }
  if (definition.kind == Definition::Kind::closure) {
    const auto& step = definition.body.literal.arguments;
    if (head.arguments.size() != 2 || step.size() != 2 || step[0] == step[1] ||
        !std::is_permutation(step.begin(), step.end(), head.arguments.begin())) {
      return data("a closure is name(X,Y) := closure other(X,Y)");
    }
  }
  return check_variables(definition.body, bound);
}

void collect_names(const Formula& formula, std::set<std::string>& names) {
  if (formula.kind == Kind::literal) names.insert(formula.literal.predicate);
  for (const auto& part : formula.parts) collect_names(part, names);
}

}  // namespace

std::string Definition::text() const {
  std::string what = Literal{head.predicate, head.arguments}.text() + " := ";
  if (kind == Kind::closure) what += "closure ";
  if (kind == Kind::count) what += "count " + joined(counted) + ": ";
  return what + text_of(body);
}

Result<Definition> definition_from_text(const std::string& line) {
  if (line.size() > kMaxLineBytes) {
    return Error{Code::data, "a definition of more than " + std::to_string(kMaxLineBytes) + " characters"};
  }
  PRIMO_ASSIGN(Definition definition, Parser(line).definition());
  PRIMO_TRY(check(definition));
  return definition;
}

Status check_order(const std::vector<Definition>& definitions) {
  const auto data = [](const std::string& message) { return Error{Code::data, message}; };
  if (definitions.size() > kMaxDefinitions) {
    return data("more than " + std::to_string(kMaxDefinitions) + " definitions");
  }
  std::set<std::string> later;
  for (auto at = definitions.rbegin(); at != definitions.rend(); ++at) {
    const std::string& name = at->head.predicate;
    if (!later.insert(name).second) return data(name + " is defined twice");
    std::set<std::string> names;
    collect_names(at->body, names);
    for (const auto& used : names) {
      if (later.contains(used)) return data(name + " uses " + used + ", which is not defined before it");
    }
  }
  return success();
}

Result<std::vector<Definition>> definitions_from_text(const std::string& text, const std::string& name) {
  std::vector<Definition> definitions;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    auto definition = definition_from_text(line);
    if (!definition.ok()) return definition.error().at(name + ":" + std::to_string(number));
    definitions.push_back(std::move(definition).value());
  }
  if (const auto status = check_order(definitions); !status.ok()) return status.error().at(name);
  return definitions;
}

}  // namespace primo::symbols

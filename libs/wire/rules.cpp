#include <algorithm>
#include <utility>

#include "core/hash.h"
#include "wire/check.h"
#include "wire/parts.h"
#include "wire/wire.h"

namespace primo::wire {
namespace {

// Beside the overloads below, not hidden by them.
using wire::from_wire;
using wire::to_wire;

Status check_probability(const std::string& field, double p) {
  if (p >= 0 && p <= 1) return success();
  return malformed(field, "is " + std::to_string(p) + ", expected a probability");
}

Status check_tally(const std::string& field, std::int64_t count) {
  if (count >= 0) return success();
  return malformed(field, "is " + std::to_string(count) + ", expected 0 or more");
}

/// The ends of the 95 % interval of `count` in the rule's examples.
std::pair<double, double> interval(std::int64_t count, const rules::Rule& rule) {
  const Rate rate{std::min(count, rule.trials()), rule.trials()};
  return {std::clamp(rate.lower(), 0.0, 1.0), std::clamp(rate.upper(), 0.0, 1.0)};
}

msg::Rule to_wire(const rules::Rule& rule) {
  msg::Rule out;
  out.action(to_wire(rule.action));
  out.preconditions(to_wire(rule.context));
  for (const rules::RuleOutcome& outcome : rule.outcomes) {
    msg::RuleOutcome entry;
    entry.p(outcome.p);
    entry.literals(to_wire(outcome.literals));
    entry.count(outcome.count);
    const auto [lower, upper] = interval(outcome.count, rule);
    entry.lower(lower);
    entry.upper(upper);
    out.outcomes().push_back(std::move(entry));
  }
  out.noise(rule.noise);
  out.noise_count(rule.noise_count);
  const auto [lower, upper] = interval(rule.noise_count, rule);
  out.noise_lower(lower);
  out.noise_upper(upper);
  out.examples(rule.examples);
  return out;
}

Result<rules::Rule> from_wire(const std::string& field, const msg::Rule& rule) {
  rules::Rule out;
  PRIMO_ASSIGN(out.action, from_wire(field + ".action", rule.action()));
  PRIMO_ASSIGN(out.context, from_wire(field + ".preconditions", rule.preconditions()));
  PRIMO_TRY(check_count(field + ".outcomes", rule.outcomes().size(), 64));
  for (const msg::RuleOutcome& entry : rule.outcomes()) {
    rules::RuleOutcome outcome;
    PRIMO_TRY(check_probability(field + ".outcomes.p", entry.p()));
    PRIMO_TRY(check_tally(field + ".outcomes.count", entry.count()));
    PRIMO_TRY(check_probability(field + ".outcomes.lower", entry.lower()));
    PRIMO_TRY(check_probability(field + ".outcomes.upper", entry.upper()));
    outcome.p = entry.p();
    outcome.count = entry.count();
    PRIMO_ASSIGN(outcome.literals, from_wire(field + ".outcomes.literals", entry.literals()));
    out.outcomes.push_back(std::move(outcome));
  }
  PRIMO_TRY(check_probability(field + ".noise", rule.noise()));
  PRIMO_TRY(check_tally(field + ".noise_count", rule.noise_count()));
  PRIMO_TRY(check_probability(field + ".noise_lower", rule.noise_lower()));
  PRIMO_TRY(check_probability(field + ".noise_upper", rule.noise_upper()));
  PRIMO_TRY(check_tally(field + ".examples", rule.examples()));
  out.noise = rule.noise();
  out.noise_count = rule.noise_count();
  out.examples = rule.examples();
  return out;
}

}  // namespace

msg::Experience to_wire(const symbols::Experience& experience, const std::string& batch) {
  msg::Experience out;
  out.batch(batch);
  out.id(experience.id);
  out.objects(experience.objects);
  out.before(to_wire(experience.before));
  out.action(to_wire(experience.action));
  out.after(to_wire(experience.after));
  return out;
}

Result<symbols::Experience> from_wire(const msg::Experience& message) {
  symbols::Experience out;
  PRIMO_TRY(check_text("experience.batch", message.batch()));
  PRIMO_TRY(check_text("experience.id", message.id()));
  if (message.id().empty()) return malformed("experience.id", "is empty");
  out.id = message.id();
  PRIMO_TRY(check_texts("experience.objects", message.objects()));
  out.objects = message.objects();
  PRIMO_ASSIGN(out.before, state_from_wire("experience.before", message.before()));
  PRIMO_ASSIGN(out.action, from_wire("experience.action", message.action()));
  PRIMO_ASSIGN(out.after, state_from_wire("experience.after", message.after()));
  return out;
}

msg::RuleSet to_wire(const rules::RuleSet& rules, const std::string& batch, const std::string& action, int experiences,
                     const std::string& digest) {
  msg::RuleSet out;
  out.batch(batch);
  out.action(action);
  out.digest(digest);
  out.experiences(experiences);
  for (const rules::Rule& rule : rules.rules) out.rules().push_back(to_wire(rule));
  for (const auto& [name, rule] : rules.defaults) {
    msg::DefaultRule entry;
    entry.action(name);
    entry.no_change(rule.no_change);
    entry.noise(rule.noise);
    entry.no_change_count(rule.no_change_count);
    entry.noise_count(rule.noise_count);
    out.defaults().push_back(std::move(entry));
  }
  for (const auto& definition : rules.derived) out.derived().push_back(definition.text());
  return out;
}

void add_news(const RuleSetNews& news, msg::RuleSet& message) {
  message.version(news.version);
  message.score(news.score);
  const auto texts = [](const std::vector<rules::Rule>& rules) {
    std::vector<std::string> list;
    for (const auto& rule : rules) list.push_back(rules::to_text(rule));
    return list;
  };
  message.added(texts(news.difference.added));
  message.removed(texts(news.difference.removed));
  message.changed(texts(news.difference.changed));
}

Result<rules::RuleSet> from_wire(const msg::RuleSet& message) {
  if (!message.error().empty()) {
    PRIMO_TRY(check_text("rule_set.error", message.error()));
    return Error{Code::failed, message.error()};
  }
  rules::RuleSet out;
  PRIMO_TRY(check_count("rule_set.rules", message.rules().size()));
  for (const msg::Rule& rule : message.rules()) {
    PRIMO_ASSIGN(rules::Rule converted, from_wire("rule_set.rules", rule));
    out.rules.push_back(std::move(converted));
  }
  PRIMO_TRY(check_count("rule_set.derived", message.derived().size()));
  for (const std::string& text : message.derived()) {
    auto definition = symbols::definition_from_text(text);
    if (!definition.ok()) return malformed("rule_set.derived", definition.error().message);
    out.derived.push_back(std::move(definition).value());
  }
  for (const auto* texts : {&message.added(), &message.removed(), &message.changed()}) {
    PRIMO_TRY(check_count("rule_set.added, removed, changed", texts->size()));
  }
  PRIMO_TRY(check_count("rule_set.defaults", message.defaults().size()));
  for (const msg::DefaultRule& entry : message.defaults()) {
    PRIMO_TRY(check_text("rule_set.defaults.action", entry.action()));
    PRIMO_TRY(check_probability("rule_set.defaults.no_change", entry.no_change()));
    PRIMO_TRY(check_probability("rule_set.defaults.noise", entry.noise()));
    PRIMO_TRY(check_tally("rule_set.defaults.no_change_count", entry.no_change_count()));
    PRIMO_TRY(check_tally("rule_set.defaults.noise_count", entry.noise_count()));
    rules::DefaultRule rule;
    rule.no_change = entry.no_change();
    rule.noise = entry.noise();
    rule.no_change_count = entry.no_change_count();
    rule.noise_count = entry.noise_count();
    if (!out.defaults.emplace(entry.action(), rule).second) {
      return malformed("rule_set.defaults", "has '" + entry.action() + "' twice");
    }
  }
  return out;
}

std::string experience_digest(const std::vector<std::string>& ids) {
  std::vector<std::string> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  Hasher hasher;
  for (const std::string& id : sorted) hasher.add(id);
  return hex(hasher.value());
}

}  // namespace primo::wire

// A study's result for people: rules, rates and precisions, before and after.
#include <algorithm>
#include <cstdio>
#include <map>

#include "study/fitness.h"
#include "study/result.h"

namespace primo::study {
namespace {

using symbols::Literal;

std::string joined(const std::vector<Literal>& literals) {
  std::string text;
  for (const auto& literal : literals) {
    if (!text.empty()) text += ", ";
    text += literal.text();
  }
  return text;
}

template <class... A>
std::string print(const char* format, A... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

std::string rule_text(const PartResult& result, const Collection& collection) {
  const auto rule = shown_rule(result, collection.rules);
  if (!rule) return "no rule of '" + result.action + "' was learned; only its default holds\n";
  std::string text = rules::to_text(*rule);
  if (!collection.untested_context.empty()) {
    text += "  (held in every experience, so untested: " + joined(collection.untested_context) + ")\n";
  }
  return text;
}

std::string rates_text(const char* name, const Collection& collection) {
  std::string text = std::string("  ") + name + "\n";
  const auto line = [&](const char* what, const Rate& rate) {
    if (rate.trials > 0) text += print("    %-38s", what) + rate.text() + "\n";
  };
  line("training scenes, strict", collection.training.strict);
  line("displaced scenes, final pose", collection.displaced.final_pose);
  line("displaced scenes, strict", collection.displaced.strict);
  line("displaced scenes, executed", collection.executed);
  line("executed, of those strictly accepted", collection.executed_of_strict);
  return text;
}

std::string rho_text(const motion::Primitive& before, const motion::Primitive& after) {
  std::string text = print("  %-24s%12s%12s\n", "log10 rho", "P", "P*");
  for (const auto& [name, old_entry, new_entry] : paired_entries(before, after)) {
    const auto value = [](const std::optional<motion::OpenEntry>& e) {
      return e ? print("%12.2f", e->value) : print("%12s", "-");
    };
    text += print("  %-24s", name.c_str()) + value(old_entry) + value(new_entry);
    text += (old_entry ? old_entry : new_entry)->log ? "\n" : "  (itself)\n";
  }
  return text;
}

/// The held-out scenarios of every level: P → P*, strict and executed.
std::string levels_text(const PartResult& part) {
  std::string text = part.levels.empty() ? "" : "\nheld-out scenarios, P → P*\n";
  for (const auto& level : part.levels) {
    text += print("  %4.1f cm  strict    ", 100 * level.displacement) + level.before.strict.text() + " → " +
            level.after.strict.text() + "\n";
    if (level.executed.trials() == 0) continue;
    text += "           executed  " + level.before.executed.text() + " → " + level.after.executed.text() + "\n";
  }
  return text;
}

std::string part_text(const PartResult& part) {
  const Collection& before = part.collections.front();
  const Collection& after = part.collections.back();
  std::string text = "before, with the hand-tuned primitive P (";
  text.append(before.primitive.name).append(")\n").append(rule_text(part, before));
  text.append("\nafter, with the optimized primitive P* (").append(after.primitive.name).append(")\n");
  text.append(rule_text(part, after))
      .append("\nrates\n")
      .append(rates_text("P", before))
      .append(rates_text("P*", after))
      .append(levels_text(part));
  text.append("\n").append(rho_text(before.primitive, after.primitive));
  return text.append("\nthe loop ended: ").append(part.end).append("\n");
}

}  // namespace

std::vector<EntryPair> paired_entries(const motion::Primitive& before, const motion::Primitive& after) {
  std::vector<EntryPair> pairs;
  for (const auto& entry : before.open_entries(0, 1)) pairs.push_back({entry.name, entry, {}});
  for (const auto& entry : after.open_entries(0, 1)) {
    const auto same =
        std::find_if(pairs.begin(), pairs.end(), [&](const EntryPair& p) { return p.name == entry.name; });
    if (same != pairs.end()) {
      same->after = entry;
    } else {
      pairs.push_back({entry.name, {}, entry});
    }
  }
  return pairs;
}

std::vector<Literal> canonical(const std::vector<Literal>& literals, const Literal& action) {
  std::map<std::string, std::string> names;
  const auto name_of = [&](const std::string& term) {
    const auto at = names.find(term);
    return at != names.end() ? at->second : names[term] = argument_variable(names.size());
  };
  for (const auto& term : action.arguments) name_of(term);
  std::vector<Literal> renamed = literals;
  for (auto& literal : renamed) {
    for (auto& term : literal.arguments) {
      if (!term.empty() && term[0] >= 'A' && term[0] <= 'Z') term = name_of(term);
    }
  }
  return renamed;
}

rules::Rule desired_rule(const rules::Rule& rule, const std::vector<Literal>& desired) {
  rules::Rule only = rule;
  std::erase_if(only.outcomes, [&](const rules::RuleOutcome& outcome) {
    const auto literals = canonical(outcome.literals, rule.action);
    return !std::all_of(desired.begin(), desired.end(), [&](const Literal& literal) {
      return std::find(literals.begin(), literals.end(), literal) != literals.end();
    });
  });
  if (only.outcomes.empty()) return rules::project_to_desired(rule);
  only.examples = rule.trials();  // what the other outcomes explained is noise now
  return rules::project_to_desired(only);
}

std::optional<rules::Rule> shown_rule(const PartResult& part, const rules::RuleSet& rules) {
  const rules::Rule* rule = rule_of(rules, part.action);
  if (rule == nullptr) return std::nullopt;
  return desired_rule(*rule, part.optimizations.empty() ? std::vector<Literal>() : part.optimizations.front().desired);
}

std::string summary(const StudyResult& result) {
  if (result.parts.empty()) return "the study has no result\n";
  std::string text;
  for (const auto& part : result.parts) {
    if (result.parts.size() > 1) text.append(text.empty() ? "" : "\n").append("== ").append(part.name).append(" ==\n");
    text += part_text(part);
  }
  return text;
}

}  // namespace primo::study

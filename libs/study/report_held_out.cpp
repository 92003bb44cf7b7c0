// The sections on held-out scenarios: generalization, paired comparison, tables of rules, causes of failure.
#include <algorithm>
#include <map>

#include "study/causes.h"
#include "study/html.h"
#include "study/published.h"
#include "study/report_parts.h"

namespace primo::study {
namespace {

using html::escape;
using html::figure;
using html::image_url;
using html::number;
using html::section;

std::string centimetres(double metres) { return number("%.1f", 100 * metres) + " cm"; }

std::string generalization(const PartMaterial& m) {
  std::string out = "<div class=\"three\">";
  for (const auto& drawing : m.generalization) out += figure(image_url(drawing.svg, "svg+xml"), drawing.figure.y_label);
  out += "</div>";
  std::vector<std::vector<std::string>> rows;
  for (const auto& level : m.result->levels) {
    const auto published = published_rate(m.result->action, level.displacement);
    std::string paper = "–";
    if (published) {
      paper = (published->before ? number("%.2f", *published->before) + " → " : std::string("→ ")) +
              number("%.2f", published->after) + "<small>" + std::string(published->source) + "</small>";
    }
    const auto &p = level.before, &q = level.after;
    rows.push_back({centimetres(level.displacement), paper, html::rate_cell(p.final_pose),
                    html::rate_cell(q.final_pose), html::rate_cell(p.strict), html::rate_cell(q.strict),
                    html::rate_cell(p.executed), html::rate_cell(q.executed), html::rate_cell(q.executed_of_strict)});
  }
  return out +
         html::table({"Displaced by ±", "Paper, final pose", "Final pose, P", "P*", "Strict, P", "P*", "Executed, P",
                      "P*", "Executed, of P*'s strict"},
                     rows) +
         "<p class=\"note\">Training scenes with every object displaced, by a seed of their own; nothing was chosen by "
         "them. Intervals are Wilson's, 95 %.</p>";
}

std::string paired(const PartMaterial& m) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& level : m.result->levels) {
    const auto row = [&](const char* what, const Paired& pair) {
      if (pair.trials() == 0) return;
      rows.push_back({centimetres(level.displacement), what, std::to_string(pair.trials()),
                      std::to_string(pair.both) + " / " + std::to_string(pair.second_only) + " / " +
                          std::to_string(pair.first_only) + " / " + std::to_string(pair.neither),
                      number("%+.3f", pair.difference()) + "<small>95 % " + number("%+.3f", pair.lower()) + " … " +
                          number("%+.3f", pair.upper()) + "</small>",
                      number("%.2g", pair.p_value()), number("%.3f", pair.detectable(0.8))});
    };
    row("final pose", level.final_pose);
    row("strict", level.strict);
    row("executed", level.executed);
  }
  std::vector<std::vector<std::string>> rejected;
  for (const auto& level : m.result->levels) {
    rejected.push_back({centimetres(level.displacement), std::to_string(level.strict.trials()),
                        std::to_string(level.rejected_touching), std::to_string(level.rejected_falling),
                        std::to_string(level.rejected_in_robot)});
  }
  return html::table({"Displaced by ±", "Verdict", "Scenarios", "Both / P* alone / P alone / neither", "P* − P",
                      "McNemar p", "Found with power .8"},
                     rows) +
         "<p class=\"note\">P and P* in the same scenarios with the same seeds. Interval of the difference: "
         "Newcombe's; p: "
         "McNemar's exact test, two-sided; the last column is the smallest difference that so many scenarios would "
         "show in four of five studies.</p><h3>Scenarios drawn and refused</h3>" +
         html::table({"Displaced by ±", "Kept", "Refused: objects touch", "Refused: an object falls off",
                      "Refused: an object in the robot"},
                     rejected);
}

std::string tables(const PartMaterial& m) {
  std::string out;
  for (const auto& level : m.result->levels) {
    const auto row = [&](const std::optional<rules::RuleSet>& before, const std::optional<rules::RuleSet>& after,
                         const std::string& from) {
      if (!before || !after) return;
      out += "<h3>" + centimetres(level.displacement) + ", " + from + "</h3><div class=\"pair\">" +
             rule_box(m, *before, "before", "with the hand-tuned P") +
             rule_box(m, *after, "after", "with the optimized P*") + "</div>";
    };
    row(level.before.rules, level.after.rules, "from final poses");
    row(level.before.executed_rules, level.after.executed_rules, "from motions executed in full physics");
    const auto published = published_rate(m.result->action, level.displacement);
    if (!level.before.rules || !published) continue;
    out += "<p class=\"note\">The paper (" + std::string(published->source) +
           "): the desired outcome with probability " +
           (published->before ? number("%.2f", *published->before) + " before and " : std::string()) +
           number("%.2f", published->after) + " after.</p>";
  }
  return out;
}

std::string cause_name(const std::string& cause) {
  for (std::size_t i = 0; i < config::EnumNames<Cause>::names.size(); ++i) {
    if (config::EnumNames<Cause>::names[i] == cause) return description(static_cast<Cause>(i));
  }
  return cause;
}

/// Counts by cause and level, P and P* side by side.
std::string cause_table(const PartMaterial& m, std::map<std::string, Example> LevelRates::*failures) {
  std::map<std::string, int> all;
  for (const auto& level : m.result->levels) {
    for (const auto* rates : {&level.before, &level.after}) {
      for (const auto& [cause, example] : rates->*failures) all[cause] += example.count;
    }
  }
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [cause, count] : all) order.emplace_back(-count, cause);
  std::sort(order.begin(), order.end());
  std::vector<std::string> head = {"Cause, P → P*"};
  for (const auto& level : m.result->levels) head.push_back(centimetres(level.displacement));
  const auto count = [](const std::map<std::string, Example>& of, const std::string& cause) {
    const auto at = of.find(cause);
    return std::to_string(at == of.end() ? 0 : at->second.count);
  };
  std::vector<std::vector<std::string>> rows;
  for (const auto& [total, cause] : order) {
    std::vector<std::string> row = {escape(cause_name(cause))};
    for (const auto& level : m.result->levels)
      row.push_back(count(level.before.*failures, cause) + " → " + count(level.after.*failures, cause));
    rows.push_back(std::move(row));
  }
  return html::table(head, rows);
}

std::string causes(const PartMaterial& m) {
  std::string out = "<h3>Strict verdict</h3>" + cause_table(m, &LevelRates::failures);
  if (m.result->levels.front().executed.trials() > 0)
    out += "<h3>Executed in full physics</h3>" + cause_table(m, &LevelRates::not_executed);
  if (m.pictures.failures.empty()) return out;
  out += "<h3>A typical failure of each of the most frequent causes</h3><div class=\"three\">";
  for (const auto& picture : m.pictures.failures) {
    out +=
        figure(image_url(picture.png), std::string(picture.optimized ? "P*" : "P") + ": " + cause_name(picture.cause) +
                                           ", " + std::to_string(picture.count) + " of " + std::to_string(picture.of) +
                                           " at " + centimetres(picture.displacement) + " (" + picture.verdict + ")");
  }
  return out + "</div>";
}

}  // namespace

std::string held_out_sections(const PartMaterial& m) {
  std::string out = section("Scenes that it has not seen", generalization(m));
  const std::string rules = tables(m);
  if (!rules.empty()) out += section("Rules on held-out scenes", rules);
  out += section("P against P* in the same scenes", paired(m));
  return out + section("Why it fails", causes(m));
}

}  // namespace primo::study

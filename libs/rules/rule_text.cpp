// Rules as people read them, in the layout of the paper's tables:
//
//   grasp(X): on(X,Y), cylinder(X), table(Y)
//     → 0.94  inhand(X), ¬on(X,Y)   (47/50, 95 % 0.84–0.98)
//       0.06  noise                 (3/50, 95 % 0.02–0.16)
#include <algorithm>
#include <cstdio>

#include "core/statistics.h"
#include "rules/rule.h"

namespace primo::rules {
namespace {

struct Line {
  double p;
  std::string what;
  Rate rate;
  bool shared = false;  // its examples are also explained otherwise, so that their number says nothing of p
};

/// Characters, not bytes: UTF-8 continuation bytes have no width.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string list(const std::vector<symbols::Literal>& literals) {
  std::string text;
  for (const auto& literal : literals) text += (text.empty() ? "" : ", ") + literal.text();
  return text;
}

std::string layout(const std::vector<Line>& lines) {
  std::size_t widest = 0;
  for (const auto& line : lines) widest = std::max(widest, width(line.what));
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& [p, what, rate, shared] = lines[i];
    char number[32];
    std::snprintf(number, sizeof number, "%.2f", p);
    text += std::string(i == 0 ? "  → " : "    ") + number + "  " + what;
    if (rate.trials > 0 && shared) {
      text += std::string(widest - width(what) + 3, ' ') + "(explains " + std::to_string(rate.successes) + " of " +
              std::to_string(rate.trials) + ", not alone)";
    } else if (rate.trials > 0) {
      char counts[96];
      std::snprintf(counts, sizeof counts, "(%lld/%lld, 95 %% %.2f–%.2f)", static_cast<long long>(rate.successes),
                    static_cast<long long>(rate.trials), rate.lower(), rate.upper());
      text += std::string(widest - width(what) + 3, ' ') + counts;
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string to_text(const Rule& rule) {
  const std::int64_t trials = rule.trials();
  std::int64_t sum = rule.noise_count;
  for (const auto& outcome : rule.outcomes) sum += outcome.count;
  const bool overlap = sum > trials;
  std::vector<Line> lines;
  for (const auto& outcome : rule.outcomes) {
    const std::string what = outcome.literals.empty() ? "no change" : list(outcome.literals);
    lines.push_back({outcome.p, what, {outcome.count, trials}, overlap});
  }
  lines.push_back({rule.noise, "noise", {rule.noise_count, trials}});
  std::string head = rule.action.text() + ":";
  if (!rule.context.empty()) head.append(" ").append(list(rule.context));
  return head + "\n" + layout(lines);
}

std::string to_text(const RuleSet& rules) {
  std::string text;
  for (const auto& definition : rules.derived) text += definition.text() + "\n";
  if (!rules.derived.empty()) text += "\n";
  for (const auto& rule : rules.rules) text += to_text(rule) + "\n";
  for (const auto& [action, rule] : rules.defaults) {
    const std::int64_t trials = rule.no_change_count + rule.noise_count;
    text += action + ", otherwise:\n" +
            layout({{rule.no_change, "no change", {rule.no_change_count, trials}},
                    {rule.noise, "noise", {rule.noise_count, trials}}});
  }
  return text;
}

}  // namespace primo::rules

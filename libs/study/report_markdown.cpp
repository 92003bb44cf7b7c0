// The results as Markdown, for a project's own documents.
#include "config/config.h"
#include "core/files.h"
#include "study/html.h"
#include "study/published.h"
#include "study/report_material.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using html::number;

/// "0.94 (376/400, .91–.96)"
std::string cell(const Rate& rate) {
  if (rate.trials == 0) return "–";
  return number("**%.3f** ", rate.value()) + std::to_string(rate.successes) + "/" + std::to_string(rate.trials) +
         number(", %.2f–", rate.lower()) + number("%.2f", rate.upper());
}

std::string row(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const auto& text : cells) out += " " + text + " |";
  return out + "\n";
}

std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  std::string out = row(head) + "|";
  for (std::size_t i = 0; i < head.size(); ++i) out += "---|";
  out += "\n";
  for (const auto& cells : rows) out += row(cells);
  return out + "\n";
}

std::string levels(const PartMaterial& m) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& level : m.result->levels) {
    const auto paper = published_rate(m.result->action, level.displacement);
    const auto &p = level.before, &q = level.after;
    rows.push_back(
        {number("%.1f", 100 * level.displacement),
         !paper
             ? "–"
             : (paper->before ? number("%.2f → ", *paper->before) : std::string("→ ")) + number("%.2f", paper->after),
         cell(p.final_pose), cell(q.final_pose), cell(p.strict), cell(q.strict), cell(p.executed), cell(q.executed)});
  }
  return table({"± cm", "paper", "final pose, P", "P*", "strict, P", "P*", "executed, P", "P*"}, rows);
}

std::string causes(const PartMaterial& m) {
  std::string out;
  for (const auto& level : m.result->levels) {
    std::string list;
    const auto& failures = level.after.executed.trials > 0 ? level.after.not_executed : level.after.failures;
    for (const auto& [cause, example] : failures)
      list += (list.empty() ? "" : ", ") + cause + " " + std::to_string(example.count);
    if (!list.empty()) out += "- ±" + number("%.1f", 100 * level.displacement) + " cm: " + list + "\n";
  }
  return out.empty() ? out : "Failures of P* when executed (of all that were), by cause:\n\n" + out + "\n";
}

std::string searches(const PartMaterial& m) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& s : summarize_searches(m.evaluations, m.finalists)) {
    const auto of = [](const Rate& rate) { return std::to_string(rate.successes) + "/" + std::to_string(rate.trials); };
    rows.push_back({s.algorithm, of(s.all_but_one_restarts), number("%.0f", s.all_but_one_mean), of(s.everywhere),
                    number("%.0f", s.evaluations_mean), number("%.0f", s.evaluations_worst),
                    of(s.recommended_everywhere), cell(s.recommended)});
  }
  return table({"search", "restarts with all scenes but one", "evaluations, mean", "with all scenes",
                "evaluations, mean", "largest", "recommendation succeeds in every trial", "its trials"},
               rows);
}

std::string rules_of(const PartMaterial& m) {
  const auto one = [&](const rules::RuleSet& rules, const char* what) {
    const auto rule = shown_rule(*m.result, rules);
    return std::string(what) + "\n\n```\n" + (rule ? rules::to_text(*rule) : "no rule\n") + "```\n\n";
  };
  return one(m.before().rules, "The rule with P:") + one(m.after().rules, "and with P*:");
}

std::string times(const Material& m) {
  double total = 0;
  for (const auto& part : m.parts) {
    for (const auto& timing : part.timings) total += timing.seconds;
  }
  return number("All stages together took %.1f min of wall clock.", total / 60) + "\n";
}

}  // namespace

Status write_markdown(const Material& m, const fs::path& file) {
  std::string out = "# Results of the study " + m.study.name + " (" + m.result.study + ")\n\n" + times(m) + "\n";
  for (const auto& part : m.parts) {
    out += "## " + part.part->name + "\n\n" + rules_of(part);
    out += "Training scenes with fresh seeds, strict: P " + cell(part.before().training.strict) + "; P* " +
           cell(part.after().training.strict) + ".\n\n" + searches(part);
    if (!part.result->levels.empty()) out += levels(part) + causes(part);
  }
  return write_file(file, out);
}

}  // namespace primo::study

// The report's numbers for other programs and for papers: CSV and LaTeX.
#include "config/config.h"
#include "core/files.h"
#include "rules/export.h"
#include "study/html.h"
#include "study/report_material.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using config::detail::format;
using html::number;

std::string rate_columns(const Rate& rate) {
  return std::to_string(rate.successes) + "," + std::to_string(rate.trials) + "," + format(rate.value()) + "," +
         format(rate.lower()) + "," + format(rate.upper());
}

/// One line for each part, level, primitive and verdict.
std::string rates_csv(const Material& m) {
  std::string out = "part,displacement_m,primitive,verdict,successes,trials,rate,lower_95,upper_95\n";
  for (const auto& part : m.parts) {
    for (const auto& level : part.result->levels) {
      const auto line = [&](const char* primitive, const char* verdict, const Rate& rate) {
        out += part.part->name + "," + format(level.displacement) + "," + primitive + "," + verdict + "," +
               rate_columns(rate) + "\n";
      };
      for (const auto& [name, rates] : {std::pair{"P", &level.before}, std::pair{"P*", &level.after}}) {
        line(name, "final_pose", rates->final_pose);
        line(name, "strict", rates->strict);
        line(name, "executed", rates->executed);
      }
    }
  }
  return out;
}

std::string causes_csv(const Material& m) {
  std::string out = "part,displacement_m,primitive,verdict,cause,count,scenarios\n";
  for (const auto& part : m.parts) {
    for (const auto& level : part.result->levels) {
      const auto lines = [&](const char* primitive, const char* verdict, const std::map<std::string, Example>& failures,
                             std::int64_t trials) {
        for (const auto& [cause, example] : failures) {
          out += part.part->name + "," + format(level.displacement) + "," + primitive + "," + verdict + "," + cause +
                 "," + std::to_string(example.count) + "," + std::to_string(trials) + "\n";
        }
      };
      for (const auto& [name, rates] : {std::pair{"P", &level.before}, std::pair{"P*", &level.after}}) {
        lines(name, "strict", rates->failures, rates->strict.trials);
        lines(name, "executed", rates->not_executed, rates->executed.trials);
      }
    }
  }
  return out;
}

/// The table of rates in LaTeX: displacement down, P and P* across.
std::string rates_tex(const PartMaterial& m) {
  std::string out =
      "\\begin{tabular}{r|cc|cc|cc}\n$\\pm$cm & final pose $P$ & $P^*$ & strict $P$ & $P^*$ & executed $P$ & $P^*$ "
      "\\\\ \\hline\n";
  const auto cell = [](const Rate& rate) {
    if (rate.trials == 0) return std::string("--");
    return number("%.2f", rate.value()) + " {\\scriptsize [" + number("%.2f", rate.lower()) + ", " +
           number("%.2f", rate.upper()) + "]}";
  };
  for (const auto& level : m.result->levels) {
    const auto &p = level.before, &q = level.after;
    out += number("%.1f", 100 * level.displacement) + " & " + cell(p.final_pose) + " & " + cell(q.final_pose) + " & " +
           cell(p.strict) + " & " + cell(q.strict) + " & " + cell(p.executed) + " & " + cell(q.executed) + " \\\\\n";
  }
  return out + "\\end{tabular}\n";
}

/// The action's rules with P and with P* at each level that has some.
std::string rules_tex(const PartMaterial& m) {
  std::string out;
  const auto one = [&](const rules::RuleSet& rules, const std::string& what) {
    if (const auto rule = shown_rule(*m.result, rules)) out += "% " + what + "\n" + rules::to_latex({{*rule}, {}, {}});
  };
  for (const auto& level : m.result->levels) {
    if (!level.before.rules || !level.after.rules) continue;
    const std::string where = number("%.1f", 100 * level.displacement) + " cm";
    one(*level.before.rules, where + ", P");
    one(*level.after.rules, where + ", P*");
  }
  if (out.empty()) {
    one(m.before().rules, "P");
    one(m.after().rules, "P*");
  }
  return out;
}

}  // namespace

Status write_tables(const Material& m, const fs::path& folder) {
  PRIMO_TRY(write_file(folder / "rates.csv", rates_csv(m)));
  PRIMO_TRY(write_file(folder / "causes.csv", causes_csv(m)));
  for (const auto& part : m.parts) {
    if (!part.result->levels.empty()) PRIMO_TRY(write_file(folder / (part.part->name + "_rates.tex"), rates_tex(part)));
    PRIMO_TRY(write_file(folder / (part.part->name + "_rules.tex"), rules_tex(part)));
  }
  return success();
}

}  // namespace primo::study

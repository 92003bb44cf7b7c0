#include "study/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/files.h"
#include "study/fitness.h"
#include "study/html.h"
#include "study/journal.h"
#include "study/report_pictures.h"
#include "study/result.h"
#include "study/study.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using html::escape;
using html::number;
using symbols::Literal;

/// What the page is made of.
struct Material {
  Study study;
  StudyResult result;
  std::vector<EvaluationRecord> evaluations;
  std::vector<FinalistRecord> finalists;
  std::vector<SensitivityRecord> sensitivities;
  std::vector<TimingRecord> timings;
  Pictures pictures;
  std::string study_yaml;

  const Collection& before() const { return result.collections.front(); }
  const Collection& after() const { return result.collections.back(); }
};

std::string section(const std::string& title, const std::string& content) {
  return "<section><h2>" + title + "</h2>\n" + content + "</section>\n";
}

std::string literals(const std::vector<Literal>& list) {
  std::string text;
  for (const auto& literal : list) text.append(text.empty() ? "" : ", ").append(escape(literal.text()));
  return text;
}

std::string outcome_row(double p, const std::string& what, const Rate& rate) {
  std::string row = "<span class=\"p\">" + number("%.2f", p) + "</span><span>";
  row.append(what)
      .append("</span><small>")
      .append(std::to_string(rate.successes))
      .append(" of ")
      .append(std::to_string(rate.trials));
  return row.append(", 95 % ")
      .append(number("%.2f", rate.lower()))
      .append("–")
      .append(number("%.2f", rate.upper()))
      .append("</small>");
}

std::string rule_box(const Material& m, const Collection& collection, const char* side, const std::string& title) {
  std::string out = std::string("<div class=\"rule ") + side + "\"><h3>" + title + "</h3>";
  const rules::Rule* learned = rule_of(collection.rules, m.result.action);
  if (learned == nullptr) return out + "<p>No rule of this action was learned; only its default holds.</p></div>";
  const auto& desired =
      m.result.optimizations.empty() ? std::vector<Literal>() : m.result.optimizations.front().desired;
  const rules::Rule rule = desired_rule(*learned, desired);
  out.append("<div class=\"head\">")
      .append(escape(rule.action.text()))
      .append(": ")
      .append(literals(rule.context))
      .append(" →</div>");
  out += "<div class=\"outcomes\">";
  for (const auto& outcome : rule.outcomes) {
    out += outcome_row(outcome.p, literals(outcome.literals), {outcome.count, rule.trials()});
  }
  out += outcome_row(rule.noise, "<i>noise</i>", {rule.noise_count, rule.trials()}) + "</div>";
  if (!collection.untested_context.empty()) {
    out.append("<p class=\"note\">Held in every experience, so the data do not say whether it matters: ");
    out.append(literals(collection.untested_context)).append(".</p>");
  }
  return out + "</div>";
}

std::string tiles(const Material& m) {
  const auto tile = [](const std::string& what, const Rate& before, const Rate& after, const std::string& note) {
    const auto percent = [](const Rate& r) {
      return r.trials > 0 ? number("%.0f", 100 * r.value()) + " %" : std::string("–");
    };
    return "<div class=\"tile\"><div class=\"what\">" + what + "</div><div class=\"big\"><i>" + percent(before) +
           "</i> → <b>" + percent(after) + "</b></div><small>" + note + "</small></div>";
  };
  const auto counts = [](const Rate& a, const Rate& b) {
    return std::to_string(a.successes) + "/" + std::to_string(a.trials) + " → " + std::to_string(b.successes) + "/" +
           std::to_string(b.trials);
  };
  const auto &p = m.before(), &q = m.after();
  return "<div class=\"tiles\">" +
         tile("Training scenes, strict success", p.training.strict, q.training.strict,
              counts(p.training.strict, q.training.strict) + " with fresh jiggle seeds") +
         tile("Displaced scenes, strict success", p.displaced.strict, q.displaced.strict,
              counts(p.displaced.strict, q.displaced.strict) + ", ±" +
                  number("%.1f", 100 * m.study.settings.experience.displacement) + " cm") +
         tile("Executed in full physics", p.executed, q.executed,
              counts(p.executed, q.executed) + " on displaced scenes") +
         "</div>";
}

std::string rates(const Material& m) {
  const auto row = [](const std::string& what, const Rate& before, const Rate& after) {
    return std::vector<std::string>{what, html::rate_cell(before), html::rate_cell(after)};
  };
  const auto &p = m.before(), &q = m.after();
  std::string out =
      html::table({"", "P, hand-tuned", "P*, optimized"},
                  {row("Training scenes, final pose", p.training.final_pose, q.training.final_pose),
                   row("Training scenes, strict", p.training.strict, q.training.strict),
                   row("Displaced scenes, final pose", p.displaced.final_pose, q.displaced.final_pose),
                   row("Displaced scenes, strict", p.displaced.strict, q.displaced.strict),
                   row("Displaced scenes, strict, desired outcome", p.displaced.desired, q.displaced.desired),
                   row("Displaced scenes, executed", p.executed, q.executed),
                   row("Executed, of those strictly accepted", p.executed_of_strict, q.executed_of_strict)});
  return out +
         "<p class=\"note\"><b>Final pose</b>: the last configuration holds the object through the jiggle, or leaves "
         "it on its support, as in the "
         "paper. <b>Strict</b>: "
         "and the path keeps clear of obstacles, table and target, joint limits and speeds. <b>Executed</b>: the whole "
         "motion in full "
         "physics. Intervals are Wilson's.</p>\n";
}

std::string pictures(const Material& m) {
  const auto figure = [](const std::string& png, const std::string& caption) {
    return "<figure><img alt=\"" + escape(caption) + "\" src=\"" + html::png_url(png) + "\"><figcaption>" +
           escape(caption) + "</figcaption></figure>";
  };
  const auto& p = m.pictures;
  return "<div class=\"pair\">" + figure(p.motion_before, "Hand-tuned P: the motion, its path dashed") +
         figure(p.motion_after, "Optimized P*: the motion, its path solid") +
         figure(p.hand_before, "P, fingers closed at the final pose: " + p.verdict_before) +
         figure(p.hand_after, "P*, fingers closed at the final pose: " + p.verdict_after) + "</div>";
}

std::string scene_picture(const Material& m) {
  return "<figure><img style=\"max-width:720px\" alt=\"training scene\" src=\"" + html::png_url(m.pictures.scene) +
         "\"><figcaption>Training scene “" + escape(m.pictures.scenario) +
         "”; the purple object is the action's.</figcaption></figure>";
}

std::string curves(const Material& m) {
  const auto curves = html::learning_curves(m.evaluations);
  return "<div class=\"pair\"><div><p class=\"note\">Success rate of the best candidate so far</p>" + curves.success +
         "</div><div><p class=\"note\">γ of the best candidate so far</p>" + curves.gamma +
         "</div></div><div class=\"legend\">" + curves.legend + "</div>";
}

/// What mattered: the loss of γ when one entry alone is moved, of the last round, the greatest first.
std::string sensitivity_table(const Material& m) {
  std::vector<SensitivityRecord> last;
  for (const auto& s : m.sensitivities) {
    if (s.round == m.sensitivities.back().round) last.push_back(s);
  }
  if (last.empty()) return {};
  const auto loss = [](const SensitivityRecord& s) { return s.gamma[0] - std::min(s.gamma[1], s.gamma[2]); };
  std::stable_sort(last.begin(), last.end(), [&](const auto& a, const auto& b) { return loss(a) > loss(b); });
  const double most = std::max(1e-9, loss(last.front()));
  const auto side = [](const SensitivityRecord& s, std::size_t i) {
    if (s.x[i] == s.x[0]) return std::string("at its bound");
    return number(s.log ? "10<sup>%.2f</sup>: " : "%.3g: ", s.x[i]) + "γ " + number("%.3f", s.gamma[i]) + ", " +
           std::to_string(s.success[i].successes) + " of " + std::to_string(s.success[i].trials);
  };
  const auto found = [](const SensitivityRecord& s) {
    return number(s.log ? "10<sup>%.2f</sup>: " : "%.3g: ", s.x[0]) + "γ " + number("%.3f", s.gamma[0]);
  };
  std::vector<std::vector<std::string>> rows;
  for (const auto& s : last) {
    rows.push_back({escape(s.entry), side(s, 1), found(s), side(s, 2),
                    number("%.3f", loss(s)) +
                        "<div class=\"bar\"><i style=\"width:" + number("%.0f", 100 * std::max(0.0, loss(s)) / most) +
                        "%;background:var(--after)\"></i></div>"});
  }
  return "<h3>What mattered</h3>" + html::table({"Entry moved", "Lower", "As found", "Higher", "Loss of γ"}, rows) +
         "<p class=\"note\">Each entry of the result by itself a step down and a step up (" +
         number("%.0f", 100 * m.study.settings.optimizer.settings.sensitivity) +
         " % of its range), on the training scenes with the seeds of the choice. Where the loss is near 0 the entry "
         "hardly "
         "matters there.</p>";
}

std::string precisions(const Material& m) {
  const auto &p = m.before().primitive, &q = m.after().primitive;
  const auto old_entries = p.open_entries(0, 1), new_entries = q.open_entries(0, 1);
  const auto value = [](const motion::OpenEntry& e) { return number("%.3g", e.log ? std::pow(10, e.value) : e.value); };
  const auto logarithm = [](const motion::OpenEntry& e) { return e.log ? number("%.2f", e.value) : std::string("–"); };
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < old_entries.size() && i < new_entries.size(); ++i) {
    const auto &before = old_entries[i], &after = new_entries[i];
    rows.push_back({escape(before.name), value(before), value(after), logarithm(before), logarithm(after)});
  }
  return html::table({"Task variable", "ρ of P", "ρ of P*", "log₁₀ P", "log₁₀ P*"}, rows) + sensitivity_table(m);
}

/// Counts of P and P* on the displaced scenes, as bars.
std::string counts_table(const Material& m, const std::string& title, const std::map<std::string, int>& before,
                         const std::map<std::string, int>& after) {
  std::map<std::string, std::pair<int, int>> counts;
  for (const auto& [name, count] : before) counts[name].first = count;
  for (const auto& [name, count] : after) counts[name].second = count;
  const auto bar = [](int count, std::int64_t of, const char* colour) {
    const double share = of > 0 ? 100.0 * count / static_cast<double>(of) : 0;
    return std::to_string(count) + "<div class=\"bar\"><i style=\"width:" + number("%.0f", share) +
           "%;background:var(" + colour + ")\"></i></div>";
  };
  std::vector<std::vector<std::string>> rows;
  for (const auto& [key, both] : counts) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    rows.push_back({escape(name), bar(both.first, m.before().displaced.strict.trials, "--before"),
                    bar(both.second, m.after().displaced.strict.trials, "--after")});
  }
  return html::table({title, "P", "P*"}, rows);
}

std::string outcomes(const Material& m) {
  return counts_table(m, "Final pose on displaced scenes", m.before().displaced.outcomes, m.after().displaced.outcomes);
}

/// Where the paper's criterion of a place and the full one differ.
std::string criteria_of_places(const Material& m) {
  return "<p>The paper's criterion is the vertical displacement at the end of the motion. The full one also asks, "
         "after the "
         "hand has let go, for horizontal offset, tilt, rest, contact with the support and none with the hand.</p>" +
         counts_table(m, "On its support, displaced scenes", m.before().displaced.on, m.after().displaced.on);
}

std::string finalists(const Material& m) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& f : m.finalists) {
    const std::string what = f.kind == "start"  ? "P itself"
                             : f.kind == "mean" ? "the distribution's mean"
                                                : "best sample";
    rows.push_back({escape(f.algorithm == "P" ? "–" : f.algorithm + " " + std::to_string(f.restart + 1)), what,
                    number("%.3f", f.gamma),
                    std::to_string(f.success.successes) + " of " + std::to_string(f.success.trials),
                    f.chosen ? "chosen" : ""});
  }
  return html::table({"Search", "Candidate", "γ", "Success", ""}, rows) +
         "<p class=\"note\">Each is tried again on the training scenes with jiggle seeds that no search has seen.</p>";
}

std::string timings(const Material& m) {
  std::vector<std::pair<std::string, std::pair<double, std::int64_t>>> stages;
  double total = 0;
  for (const auto& t : m.timings) {
    auto at = std::find_if(stages.begin(), stages.end(), [&](const auto& stage) { return stage.first == t.stage; });
    if (at == stages.end()) at = stages.insert(stages.end(), {t.stage, {0.0, 0}});
    at->second.first += t.seconds;
    at->second.second += t.rollouts;
    total += t.seconds;
  }
  std::vector<std::vector<std::string>> rows;
  for (const auto& [stage, sums] : stages) {
    std::string rollouts = stage == "optimize"
                               ? std::to_string(m.evaluations.size() * m.study.training.size()) + " in the search"
                               : std::to_string(sums.second);
    rows.push_back({escape(stage), number("%.1f s", sums.first), rollouts});
  }
  rows.push_back({"all", number("%.1f s", total), ""});
  return html::table({"Stage", "Wall clock", "Rollouts"}, rows);
}

std::string page(const Material& m) {
  const std::string title = "primo: " + m.study.name;
  std::string out =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      escape(title) + "</title><style>" + html::kStyle + "</style></head><body><main>\n<h1>" + escape(m.study.name) +
      "</h1><p class=\"sub\">Optimizing the motion primitive of <b>" + escape(m.result.action) +
      "</b> until its symbolic rule predicts what happens. Study " + escape(m.result.study) + ", " +
      std::to_string(m.result.optimizations.size()) + (m.result.optimizations.size() == 1 ? " round; " : " rounds; ") +
      escape(m.result.end) + ".</p>\n";
  out += tiles(m);
  const std::string trials = std::to_string(m.before().displaced.strict.trials);
  out += section("The rule, before and after",
                 "<div class=\"pair\">" +
                     rule_box(m, m.before(), "before", "learned from " + trials + " tries with the hand-tuned P") +
                     rule_box(m, m.after(), "after", "learned from " + trials + " tries with the optimized P*") +
                     "</div>");
  out += section("The same scene, before and after", pictures(m));
  out += section("How often it works", rates(m));
  out += section("The search", curves(m));
  out += section("Precisions", precisions(m));
  out += section(m.before().displaced.on.empty() ? "How the grasps ended" : "How the places ended", outcomes(m));
  if (!m.before().displaced.on.empty()) out += section("Two criteria of a place", criteria_of_places(m));
  out += section("The choice", finalists(m));
  out += section("A training scene", scene_picture(m));
  out += section("Behind it", timings(m) + "<details><summary>All learned rules</summary><pre>with P\n\n" +
                                  escape(rules::to_text(m.before().rules)) + "\nwith P*\n\n" +
                                  escape(rules::to_text(m.after().rules)) +
                                  "</pre></details><details><summary>All settings, " +
                                  "primitive and scenarios</summary><pre>" + escape(m.study_yaml) + "</pre></details>");
  return out + "</main></body></html>\n";
}

}  // namespace

Result<fs::path> write_report(const fs::path& study_directory) {
  const fs::path directory = fs::absolute(study_directory).lexically_normal();
  Material m;
  PRIMO_ASSIGN(m.study, read_study(directory));
  PRIMO_ASSIGN(m.study_yaml, read_file(directory / "study.yaml"));
  PRIMO_ASSIGN(m.result, read_result(directory));
  if (m.result.collections.empty())
    return Error{Code::data, (directory / "result.json").string() + ": has no collections"};
  {
    PRIMO_ASSIGN(Journal journal, Journal::open_existing(journal_file(directory)));
    PRIMO_ASSIGN(m.evaluations, journal.evaluations());
    PRIMO_ASSIGN(m.finalists, journal.finalists());
    PRIMO_ASSIGN(m.sensitivities, journal.sensitivities());
    PRIMO_ASSIGN(m.timings, journal.timings());
  }
  const fs::path folder = directory / "report";
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return Error{Code::unavailable, folder.string() + ": cannot be created: " + failure.message()};
  PRIMO_ASSIGN(m.pictures, draw_pictures(m.study, m.result, folder));
  PRIMO_TRY(write_file(folder / "index.html", page(m)));
  return folder / "index.html";
}

}  // namespace primo::study

// The sections of one part of a study: rules, rates, search, precisions.
#include <algorithm>
#include <cmath>
#include <map>

#include "rules/analysis.h"
#include "study/fitness.h"
#include "study/html.h"
#include "study/report_parts.h"

namespace primo::study {
namespace {

using html::escape;
using html::figure;
using html::image_url;
using html::number;
using html::section;

std::string counts(const Rate& a, const Rate& b) {
  return std::to_string(a.successes) + "/" + std::to_string(a.trials) + " → " + std::to_string(b.successes) + "/" +
         std::to_string(b.trials);
}

std::string tiles(const PartMaterial& m) {
  const auto tile = [](const std::string& what, const Rate& before, const Rate& after, const std::string& note) {
    const auto percent = [](const Rate& r) {
      return r.trials > 0 ? number("%.0f", 100 * r.value()) + " %" : std::string("–");
    };
    return "<div class=\"tile\"><div class=\"what\">" + what + "</div><div class=\"big\"><i>" + percent(before) +
           "</i> → <b>" + percent(after) + "</b></div><small>" + note + "</small></div>";
  };
  const auto &p = m.before(), &q = m.after();
  return "<div class=\"tiles\">" +
         tile("Training scenes, strict success", p.training.strict, q.training.strict,
              counts(p.training.strict, q.training.strict) + " with fresh jiggle seeds") +
         tile("Displaced scenes, strict success", p.displaced.strict, q.displaced.strict,
              counts(p.displaced.strict, q.displaced.strict) + ", ±" +
                  number("%.1f", 100 * m.part->settings.experience.displacement) + " cm") +
         tile("Executed in full physics", p.executed, q.executed,
              counts(p.executed, q.executed) + " on displaced scenes") +
         "</div>";
}

std::string rates(const PartMaterial& m) {
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

/// What mattered: the loss of γ when one entry alone is moved, of the last round, the greatest first.
std::string sensitivity_table(const PartMaterial& m) {
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
         number("%.0f", 100 * m.part->settings.optimizer.settings.sensitivity) +
         " % of its range), on the training scenes with the seeds of the choice. Where the loss is near 0 the entry "
         "hardly "
         "matters there.</p>";
}

std::string precisions(const PartMaterial& m) {
  const auto value = [](const std::optional<motion::OpenEntry>& e) {
    return e ? number("%.3g", e->log ? std::pow(10, e->value) : e->value) : std::string("–");
  };
  const auto logarithm = [](const std::optional<motion::OpenEntry>& e) {
    return e && e->log ? number("%.2f", e->value) : std::string("–");
  };
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, before, after] : paired_entries(m.before().primitive, m.after().primitive)) {
    rows.push_back({escape(name), value(before), value(after), logarithm(before), logarithm(after)});
  }
  const std::string structure = m.part->structure ? "<p class=\"note\">The search began with the task variables of “" +
                                                        escape(m.part->structure->name) +
                                                        "”, not with those of P; where only one has an entry, the "
                                                        "other has none such.</p>"
                                                  : "";
  return html::table({"Task variable", "ρ of P", "ρ of P*", "log₁₀ P", "log₁₀ P*"}, rows) + structure +
         sensitivity_table(m);
}

/// Counts of P and P* on the displaced scenes, as bars.
std::string counts_table(const PartMaterial& m, const std::string& title, const std::map<std::string, int>& before,
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

std::string outcomes(const PartMaterial& m) {
  return counts_table(m, "Final pose on displaced scenes", m.before().displaced.outcomes, m.after().displaced.outcomes);
}

/// Where the paper's criterion of a place and the full one differ.
std::string criteria_of_places(const PartMaterial& m) {
  return "<p>The paper's criterion is the vertical displacement at the end of the motion. The full one also asks, "
         "after the "
         "hand has let go, for horizontal offset, tilt, rest, contact with the support and none with the hand.</p>" +
         counts_table(m, "On its support, displaced scenes", m.before().displaced.on, m.after().displaced.on);
}

std::string finalists(const PartMaterial& m) {
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

std::string before_and_after(const PartMaterial& m) {
  const auto trials = std::to_string(m.before().displaced.strict.trials);
  const std::string how = m.part->settings.experience.mode == physics::Mode::execute
                              ? " tries, executed in full physics, with "
                              : " tries with ";
  return "<div class=\"pair\">" +
         rule_box(m, m.before().rules, "before", "learned from " + trials + how + "the hand-tuned P",
                  m.before().untested_context) +
         rule_box(m, m.after().rules, "after", "learned from " + trials + how + "the optimized P*",
                  m.after().untested_context) +
         "</div>";
}

std::string pictures(const PartMaterial& m) {
  const auto& p = m.pictures;
  const std::string end =
      m.part->training.front().held ? " at the final pose: " : ", fingers closed at the final pose: ";
  return "<div class=\"pair\">" +
         figure(image_url(p.motion_before), "Hand-tuned P: start, middle and end of the motion, its path dashed") +
         figure(image_url(p.motion_after), "Optimized P*: the motion, its path solid") +
         figure(image_url(p.hand_before), "P" + end + p.verdict_before) +
         figure(image_url(p.hand_after), "P*" + end + p.verdict_after) +
         figure(image_url(p.motion_both), "Both paths in training scene “" + p.scenario + "”: P* solid, P beside it") +
         figure(image_url(p.scene), "Training scene “" + p.scenario + "”; the purple object is the action's") +
         "</div>";
}

std::string curves(const PartMaterial& m) {
  std::string out = "<div class=\"pair\">";
  for (const auto& drawing : m.curves) out += figure(image_url(drawing.svg, "svg+xml"), drawing.figure.y_label);
  return out +
         "</div><p class=\"note\">Of the best candidate so far, by γ; mean over restarts with its standard error. "
         "The paper: both algorithms rise to a success rate of 1 within 2000 evaluations, CMA-ES in all 10 restarts "
         "(its Figures 2 and 5).</p>";
}

std::string searches(const PartMaterial& m) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& s : summarize_searches(m.evaluations, m.finalists)) {
    const auto needed = [](const Rate& rate, double mean) {
      return std::to_string(rate.successes) + " of " + std::to_string(rate.trials) +
             (rate.successes > 0 ? "<small>after " + number("%.0f", mean) + " evaluations in the mean</small>" : "");
    };
    rows.push_back(
        {escape(s.algorithm), needed(s.all_but_one_restarts, s.all_but_one_mean),
         needed(s.everywhere, s.evaluations_mean),
         s.everywhere.successes > 0 ? number("%.0f", s.evaluations_worst) : "–",
         std::to_string(s.recommended_everywhere.successes) + " of " + std::to_string(s.recommended_everywhere.trials),
         html::rate_cell(s.recommended)});
  }
  return html::table(
             {"Search", "Restarts with all scenes but one", "With all scenes", "Evaluations, the slowest of these",
              "Recommendation succeeds in every trial", "Trials of the recommendations"},
             rows) +
         "<p class=\"note\">The first columns count candidates during the search, the last two the recommendation of "
         "each "
         "restart, tried again with seeds that no search has seen.</p>";
}

/// What changed from round to round, with the entropy and the noise of the action's rule.
std::string rounds(const PartMaterial& m) {
  std::vector<std::vector<std::string>> rows;
  const auto& collections = m.result->collections;
  const auto heads = [](const std::vector<rules::Rule>& list) {
    std::string text;
    for (const auto& rule : list) {
      text += text.empty() ? "" : "<br>";
      text += escape(rule.action.text()) + ": " + literals(rule.context);
    }
    return text.empty() ? std::string("–") : text;
  };
  for (std::size_t c = 0; c < collections.size(); ++c) {
    const auto* rule = rule_of(collections[c].rules, m.result->action);
    const auto change = c > 0 ? rules::difference(collections[c - 1].rules, collections[c].rules) : rules::Difference{};
    rows.push_back({c == 0 ? "P" : "round " + std::to_string(c),
                    rule != nullptr ? number("%.3f", rules::entropy(*rule)) : "–",
                    rule != nullptr ? number("%.3f", rule->noise) : "–", heads(change.added), heads(change.removed),
                    heads(change.changed)});
  }
  return html::table({"Rules of", "Entropy, nats", "Noise", "Added", "Removed", "Changed"}, rows) +
         "<p class=\"note\">The loop ended: " + escape(m.result->end) + ".</p>";
}

}  // namespace

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

std::string rule_box(const PartMaterial& m, const rules::RuleSet& rules, const char* side, const std::string& title,
                     const std::vector<Literal>& untested) {
  std::string out = std::string("<div class=\"rule ") + side + "\"><h3>" + title + "</h3>";
  const auto shown = shown_rule(*m.result, rules);
  if (!shown) return out + "<p>No rule of this action was learned; only its default holds.</p></div>";
  const rules::Rule& rule = *shown;
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
  if (!untested.empty()) {
    out.append("<p class=\"note\">Held in every experience, so the data do not say whether it matters: ");
    out.append(literals(untested)).append(".</p>");
  }
  return out + "</div>";
}

std::string part_sections(const PartMaterial& m) {
  std::string out = tiles(m);
  out += section("The rule, before and after", before_and_after(m));
  out += section("The same scene, before and after", pictures(m));
  out += section("How often it works", rates(m));
  if (!m.result->levels.empty()) out += held_out_sections(m);
  out += section("The search", curves(m) + searches(m));
  out += section("Round by round", rounds(m));
  out += section("Precisions", precisions(m));
  out += section(m.before().displaced.on.empty() ? "How the grasps ended" : "How the places ended", outcomes(m));
  if (!m.before().displaced.on.empty()) out += section("Two criteria of a place", criteria_of_places(m));
  return out + section("The choice", finalists(m));
}

}  // namespace primo::study

// What lies behind a study: time, throughput, disk, packages, settings.
#include <algorithm>
#include <array>

#include "core/program.h"
#include "study/html.h"
#include "study/journal.h"
#include "study/report_material.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using html::escape;
using html::number;

/// Rollouts that the candidates of a part's searches took.
std::int64_t rollouts_in_search(const PartMaterial& m) {
  std::int64_t rollouts = 0;
  for (const auto& evaluation : m.evaluations) rollouts += evaluation.scenarios;
  return rollouts;
}

std::string timings(const Material& m) {
  std::vector<std::vector<std::string>> rows;
  double total = 0;
  std::int64_t all_rollouts = 0;
  const auto row = [&](const std::string& part, const std::string& stage, double seconds, std::int64_t rollouts) {
    rows.push_back({escape(part), escape(stage), number("%.1f s", seconds),
                    rollouts > 0 ? std::to_string(rollouts) : "",
                    rollouts > 0 && seconds > 0 ? number("%.1f", static_cast<double>(rollouts) / seconds) : ""});
  };
  for (const auto& part : m.parts) {
    std::vector<std::pair<std::string, std::pair<double, std::int64_t>>> stages;
    for (const auto& t : part.timings) {
      auto at = std::find_if(stages.begin(), stages.end(), [&](const auto& stage) { return stage.first == t.stage; });
      if (at == stages.end()) at = stages.insert(stages.end(), {t.stage, {0.0, 0}});
      at->second.first += t.seconds;
      at->second.second += t.stage == "optimize" ? 0 : t.rollouts;
    }
    for (auto& [stage, sums] : stages) {
      if (stage == "optimize") sums.second = rollouts_in_search(part);
      row(part.part->name, stage, sums.first, sums.second);
      total += sums.first;
      all_rollouts += sums.second;
    }
  }
  row("all", "", total, all_rollouts);
  return html::table({"Part", "Stage", "Wall clock", "Rollouts", "a second"}, rows) +
         "<p class=\"note\">Stages that were interrupted count from their last start. Rollouts that the journal "
         "already "
         "knew are not counted, but for the search, where all of its candidates are.</p>";
}

std::string disk(const Material& m) {
  std::error_code ignored;
  const auto bytes = fs::file_size(journal_file(m.directory), ignored);
  return ignored ? std::string()
                 : "<p>The journal takes " + number("%.1f", static_cast<double>(bytes) / (1 << 20)) + " MiB.</p>";
}

/// Versions of the packages that the result depends on, as Debian names them.
std::string versions() {
  static constexpr std::array<const char*, 9> kPackages = {"libmujoco-dev",       "libeigen3-dev",   "liboctomap-dev",
                                                           "coinor-libipopt-dev", "libfastrtps-dev", "libsqlite3-dev",
                                                           "libyaml-cpp-dev",     "gnuplot-nox",     "g++"};
  std::vector<std::string> words = {"dpkg-query", "-W", "-f", "${Package}\t${Version}\n"};
  words.insert(words.end(), kPackages.begin(), kPackages.end());
  const auto found = run_program(words);
  if (!found.ok())
    return "<p class=\"note\">Versions of packages: not known, " + escape(found.error().message) + ".</p>";
  std::vector<std::vector<std::string>> rows;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = found->output.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string line = found->output.substr(begin, end - begin);
    const auto tab = line.find('\t');
    if (tab != std::string::npos) rows.push_back({escape(line.substr(0, tab)), escape(line.substr(tab + 1))});
  }
  return html::table({"Package", "Version"}, rows);
}

}  // namespace

std::string background_sections(const Material& m) {
  std::string all_rules;
  for (const auto& part : m.parts) {
    all_rules += part.part->name + ", with P\n\n" + rules::to_text(part.before().rules) + "\n" + part.part->name +
                 ", with P*\n\n" + rules::to_text(part.after().rules) + "\n";
  }
  return html::section("Behind it",
                       timings(m) + disk(m) + "<details><summary>All learned rules</summary><pre>" + escape(all_rules) +
                           "</pre></details><details><summary>Versions</summary>" + versions() +
                           "</details><details><summary>All settings, primitives and scenarios</summary><pre>" +
                           escape(m.study_yaml) + "</pre></details>");
}

}  // namespace primo::study

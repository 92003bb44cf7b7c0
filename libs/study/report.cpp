#include "study/report.h"

#include <algorithm>
#include <utility>

#include "core/files.h"
#include "study/html.h"
#include "study/report_material.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using html::escape;

template <class Record>
std::vector<Record> of_part(const std::vector<Record>& all, const std::string& part) {
  std::vector<Record> own;
  for (const auto& record : all) {
    if (record.part == part) own.push_back(record);
  }
  return own;
}

Status draw_into(const Figure& figure, const fs::path& folder, std::vector<Drawing>& drawings) {
  if (figure.series.empty()) return success();
  PRIMO_TRY(draw(figure, folder));
  PRIMO_ASSIGN(auto svg, read_file(folder / (figure.name + ".svg")));
  drawings.push_back({figure, std::move(svg)});
  return success();
}

/// Draws everything that a part's sections show.
Status draw_part(LocalWorkers& workers, Journal& journal, const fs::path& folder, PartMaterial& m) {
  const auto curves = learning_curves(m.part->name, m.evaluations);
  PRIMO_TRY(draw_into(curves.success, folder, m.curves));
  PRIMO_TRY(draw_into(curves.gamma, folder, m.curves));
  for (const auto& figure : generalization_figures(*m.result)) PRIMO_TRY(draw_into(figure, folder, m.generalization));
  PRIMO_ASSIGN(m.pictures, draw_pictures(workers, *m.part, *m.result, journal, folder));
  return success();
}

Result<Material> load(const fs::path& directory, Journal& journal) {
  Material m;
  m.directory = directory;
  PRIMO_ASSIGN(m.study, read_study(directory));
  PRIMO_ASSIGN(m.study_yaml, read_file(directory / "study.yaml"));
  PRIMO_ASSIGN(m.result, read_result(directory));
  const std::string where = (directory / "result.json").string();
  if (m.result.parts.size() != m.study.parts.size())
    return Error{Code::data, where + ": is not of the study in study.yaml; the numbers of parts differ"};
  PRIMO_ASSIGN(const auto evaluations, journal.evaluations());
  PRIMO_ASSIGN(const auto finalists, journal.finalists());
  PRIMO_ASSIGN(const auto sensitivities, journal.sensitivities());
  PRIMO_ASSIGN(const auto timings, journal.timings());
  for (std::size_t i = 0; i < m.study.parts.size(); ++i) {
    PartMaterial part;
    const std::string& name = m.study.parts[i].name;
    if (m.result.parts[i].collections.empty() || m.result.parts[i].name != name)
      return Error{Code::data, where + ": has no collections of part '" + name + "'"};
    part.evaluations = of_part(evaluations, name);
    part.finalists = of_part(finalists, name);
    part.sensitivities = of_part(sensitivities, name);
    part.timings = of_part(timings, name);
    m.parts.push_back(std::move(part));
  }
  return m;
}

std::string head(const Material& m) {
  std::string out =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      escape("primo: " + m.study.name) + "</title><style>" + html::kStyle + "</style></head><body><main>\n<h1>" +
      escape(m.study.name) +
      "</h1><p class=\"sub\">Optimizing motion primitives until their symbolic rules predict what "
      "happens. Study " +
      escape(m.result.study) + ".</p>\n";
  if (m.parts.size() < 2) return out;
  out += "<nav>";
  for (const auto& part : m.parts) {
    out += "<a href=\"#" + escape(part.part->name) + "\">" + escape(part.part->name) + "</a>";
  }
  return out + "</nav>\n";
}

/// Executed success on held-out scenarios, all parts in one table.
std::string overview(const Material& m) {
  std::vector<double> levels;
  for (const auto& part : m.parts) {
    for (const auto& level : part.result->levels) levels.push_back(level.displacement);
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  if (m.parts.size() < 2 || levels.empty()) return {};
  std::vector<std::string> head = {"Part", "Primitive", "Training, strict"};
  for (const double level : levels) head.push_back("±" + html::number("%.1f cm", 100 * level));
  std::vector<std::vector<std::string>> rows;
  for (const auto& part : m.parts) {
    for (const bool optimized : {false, true}) {
      const Collection& collection = optimized ? part.after() : part.before();
      std::vector<std::string> row = {escape(part.part->name), optimized ? "P*" : "P",
                                      html::rate_cell(collection.training.strict)};
      for (const double displacement : levels) {
        Rate rate;
        for (const auto& level : part.result->levels) {
          if (level.displacement == displacement) rate = optimized ? level.after.executed : level.before.executed;
        }
        row.push_back(html::rate_cell(rate));
      }
      rows.push_back(std::move(row));
    }
  }
  return html::section("Executed in full physics, in scenes that nothing was chosen by", html::table(head, rows));
}

std::string page(const Material& m) {
  std::string out = head(m) + overview(m);
  for (const auto& part : m.parts) {
    const auto rounds = part.result->optimizations.size();
    out += "<h2 class=\"part\" id=\"" + escape(part.part->name) + "\">" + escape(part.part->name) + ": " +
           escape(part.result->action) + ", " + std::to_string(rounds) + (rounds == 1 ? " round" : " rounds") +
           "</h2>\n";
    out += part_sections(part);
  }
  return out + background_sections(m) + "</main></body></html>\n";
}

}  // namespace

Result<fs::path> write_report(const fs::path& study_directory) {
  const fs::path directory = fs::absolute(study_directory).lexically_normal();
  PRIMO_ASSIGN(Journal journal, Journal::open_existing(journal_file(directory)));
  PRIMO_ASSIGN(Material m, load(directory, journal));
  const fs::path folder = directory / "report";
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) return Error{Code::unavailable, folder.string() + ": cannot be created: " + failure.message()};
  PRIMO_ASSIGN(const auto workers, LocalWorkers::create(m.study.robot));
  for (std::size_t i = 0; i < m.parts.size(); ++i) {
    m.parts[i].part = &m.study.parts[i];
    m.parts[i].result = &m.result.parts[i];
    PRIMO_TRY(draw_part(*workers, journal, folder, m.parts[i]));
  }
  PRIMO_TRY(write_tables(m, folder));
  PRIMO_TRY(write_markdown(m, folder / "results.md"));
  PRIMO_TRY(write_file(folder / "index.html", page(m)));
  return folder / "index.html";
}

}  // namespace primo::study

// primo study diff and export: two studies compared; what a study has seen, for other programs.
#include <algorithm>
#include <iostream>
#include <sstream>

#include "core/files.h"
#include "primo/study_verbs.h"
#include "study/result.h"
#include "study/study.h"
#include "symbols/literal_json.h"

namespace primo::tool {
namespace {

namespace fs = std::filesystem;

/// A study's directory, or a study file.
Result<study::Study> open_study(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? study::read_study(path) : study::load_study(path);
}

/// Rates of the parts that both have results of.
Status print_results(const std::string& first, const std::string& second) {
  std::error_code ignored;
  if (!fs::exists(fs::path(first) / "result.json", ignored) || !fs::exists(fs::path(second) / "result.json", ignored))
    return success();
  PRIMO_ASSIGN(const auto one, study::read_result(first));
  PRIMO_ASSIGN(const auto other, study::read_result(second));
  for (const auto& part : one.parts) {
    for (const auto& same : other.parts) {
      if (same.name != part.name) continue;
      const auto line = [&](const char* what, const Rate& a, const Rate& b) {
        if (a.trials > 0 || b.trials > 0)
          std::cout << "  " << part.name << ", P*, " << what << ": " << a.text() << " | " << b.text() << "\n";
      };
      const auto &a = part.collections.back(), &b = same.collections.back();
      line("training, strict", a.training.strict, b.training.strict);
      line("displaced, strict", a.displaced.strict, b.displaced.strict);
      line("displaced, executed", a.executed, b.executed);
      for (std::size_t i = 0; i < std::min(part.levels.size(), same.levels.size()); ++i) {
        if (part.levels[i].displacement != same.levels[i].displacement) continue;
        const std::string where = "held out ±" + config::detail::format(100 * part.levels[i].displacement) + " cm, ";
        line((where + "strict").c_str(), part.levels[i].after.strict, same.levels[i].after.strict);
        line((where + "executed").c_str(), part.levels[i].after.executed, same.levels[i].after.executed);
      }
    }
  }
  return success();
}

/// Experience files of a study: experience-PART-COLLECTION.jsonl.
struct ExperienceFile {
  std::string part;
  std::size_t collection = 0;
  fs::path path;
};

Result<std::vector<ExperienceFile>> experience_files(const fs::path& directory) {
  PRIMO_ASSIGN(const auto study, study::read_study(directory));
  std::vector<ExperienceFile> files;
  for (const auto& part : study.parts) {
    std::error_code ignored;
    for (std::size_t c = 0;; ++c) {
      const fs::path path = directory / ("experience-" + part.name + "-" + std::to_string(c) + ".jsonl");
      if (!fs::exists(path, ignored)) break;
      files.push_back({part.name, c, path});
    }
  }
  if (files.empty())
    return Error{Code::data, directory.string() + ": has no experience yet; it is there once P has been tried"};
  return files;
}

/// A field of a CSV line.
std::string field(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? "\"\"" : std::string(1, c));
  return out + "\"";
}

std::string joined(const symbols::State& state) {
  std::string text;
  for (const auto& literal : state) text.append(text.empty() ? "" : " ").append(literal.text());
  return text;
}

std::string only(const symbols::State& these, const symbols::State& not_those) {
  symbols::State left;
  for (const auto& literal : these) {
    if (!not_those.contains(literal)) left.insert(literal);
  }
  return joined(left);
}

Status export_csv(const std::vector<ExperienceFile>& files, std::ostream& out) {
  out << "part,collection,id,action,before,added,removed\n";
  for (const auto& file : files) {
    PRIMO_ASSIGN(const std::string text, read_file(file.path));
    std::istringstream lines(text);
    int number = 1;
    for (std::string line; std::getline(lines, line); ++number) {
      const auto experience = symbols::experience_from_json(line);
      if (!experience.ok()) return experience.error().at(file.path.string() + ":" + std::to_string(number));
      out << file.part << "," << file.collection << "," << field(experience->id) << ","
          << field(experience->action.text()) << "," << field(joined(experience->before)) << ","
          << field(only(experience->after, experience->before)) << ","
          << field(only(experience->before, experience->after)) << "\n";
    }
  }
  return success();
}

Status export_lines(const std::vector<ExperienceFile>& files, std::ostream& out) {
  for (const auto& file : files) {
    PRIMO_ASSIGN(const std::string text, read_file(file.path));
    out << text;
  }
  return success();
}

}  // namespace

Status diff_studies(const std::string& first, const std::string& second) {
  PRIMO_ASSIGN(const auto one, open_study(first));
  PRIMO_ASSIGN(const auto other, open_study(second));
  PRIMO_ASSIGN(const auto found, study::differences(one, other));
  if (found.empty()) std::cout << "the same settings, primitives and scenarios\n";
  for (const auto& d : found) std::cout << d.key << ": " << d.first << " | " << d.second << "\n";
  return print_results(first, second);
}

Status export_experience(const std::string& directory, const std::string& format, const std::string& file) {
  PRIMO_ASSIGN(const auto files, experience_files(directory));
  std::ostringstream text;
  PRIMO_TRY(format == "csv" ? export_csv(files, text) : export_lines(files, text));
  if (file.empty()) {
    std::cout << text.str();
    return success();
  }
  return write_file(file, text.str());
}

}  // namespace primo::tool

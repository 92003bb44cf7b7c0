// What the report's pages are made of. Private to libs/study.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/curves.h"
#include "study/journal.h"
#include "study/report_pictures.h"
#include "study/result.h"
#include "study/study.h"

namespace primo::study {

/// A figure with its picture.
struct Drawing {
  Figure figure;
  std::string svg;
};

struct PartMaterial {
  const Part* part = nullptr;
  const PartResult* result = nullptr;
  std::vector<EvaluationRecord> evaluations;
  std::vector<FinalistRecord> finalists;
  std::vector<SensitivityRecord> sensitivities;
  std::vector<TimingRecord> timings;
  PartPictures pictures;
  std::vector<Drawing> curves;          ///< success and γ against evaluations
  std::vector<Drawing> generalization;  ///< those with data

  const Collection& before() const { return result->collections.front(); }
  const Collection& after() const { return result->collections.back(); }
};

struct Material {
  Study study;
  StudyResult result;
  std::vector<PartMaterial> parts;
  std::string study_yaml;
  std::filesystem::path directory;
};

/// The sections of one part, as HTML.
std::string part_sections(const PartMaterial& m);

/// Time, throughput, disk, versions, settings.
std::string background_sections(const Material& m);

/// Rates, causes and rules as CSV and LaTeX, written into the folder.
Status write_tables(const Material& m, const std::filesystem::path& folder);

/// The main results as Markdown.
Status write_markdown(const Material& m, const std::filesystem::path& file);

}  // namespace primo::study

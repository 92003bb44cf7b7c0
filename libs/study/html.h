// Pieces of the report's page. Private to libs/study.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "study/journal.h"

namespace primo::study::html {

/// `text` safe in elements and attributes.
std::string escape(std::string_view text);

/// Printf of a double.
std::string number(const char* format, double value);

/// A data: URL of a PNG's bytes.
std::string png_url(std::string_view bytes);

/// "83 %" with "5 of 6, 95 % 44–97 %" below; a dash without trials.
std::string rate_cell(const Rate& rate);

/// A table from its head and rows; cells are HTML. The first column is a row's head.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);

/// The style sheet: light and dark, from a phone to a wide screen.
extern const char* const kStyle;

/// Success rate and γ of the best candidate so far against evaluations, one line for each algorithm (the mean over its
/// restarts, with its standard error as a band), as an SVG element for each of the two.
struct Curves {
  std::string success, gamma, legend;
};
Curves learning_curves(const std::vector<EvaluationRecord>& evaluations);

}  // namespace primo::study::html

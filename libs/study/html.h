// Pieces of the report's page. Private to libs/study.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/statistics.h"

namespace primo::study::html {

/// `text` safe in elements and attributes.
std::string escape(std::string_view text);

/// Printf of a double.
std::string number(const char* format, double value);

/// A data: URL of an image's bytes; `type` as in "png" or "svg+xml".
std::string image_url(std::string_view bytes, std::string_view type = "png");

/// A picture with its caption, which also stands in for it.
std::string figure(const std::string& url, const std::string& caption);

/// A section with its title.
std::string section(const std::string& title, const std::string& content);

/// "83 %" with "5 of 6, 95 %: 44–97 %" below; a dash without trials.
std::string rate_cell(const Rate& rate);

/// A table from its head and rows; cells are HTML. The first column is a row's head.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);

/// The style sheet: light and dark, from a phone to a wide screen.
extern const char* const kStyle;

}  // namespace primo::study::html

// Figures of the report, drawn by gnuplot: each as SVG, PNG, the script that draws it, and its data as CSV.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace primo::study {

/// One line of a figure. low and high are empty, or as long as x and y: a band or bars around the line.
struct Series {
  std::string label;
  std::vector<double> x, y, low, high;
  bool dashed = false;
  int colour = 0;     ///< 0 … 3
  bool bars = false;  ///< intervals as bars with a point each, else as a band
};

struct Figure {
  std::string name;  ///< of its files, without an ending
  std::string title, x_label, y_label;
  double y_low = 0, y_high = 0;  ///< equal: as the data are
  std::vector<Series> series;
};

/// The data: a line for each point, "series,x,y,low,high" with a head; low and high empty where there are none.
std::string to_csv(const Figure& figure);

/// Writes NAME.csv, NAME.gp, NAME.svg and NAME.png into the folder. Errors: gnuplot is missing (unavailable) or fails;
/// a file that cannot be written.
Status draw(const Figure& figure, const std::filesystem::path& folder);

}  // namespace primo::study

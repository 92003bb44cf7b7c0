#include "study/figure.h"

#include <algorithm>
#include <array>

#include "config/config.h"
#include "core/files.h"
#include "core/program.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;
using config::detail::format;

/// Told apart by the colour-blind too (Okabe and Ito).
constexpr std::array<const char*, 4> kColours = {"#D55E00", "#0072B2", "#009E73", "#CC79A7"};

/// A text in a gnuplot script.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out.append(c == '\'' ? "''" : std::string(1, c));
  return out + "'";
}

bool has_interval(const Series& series) { return !series.low.empty(); }

std::string data_block(const Series& series, const std::string& name) {
  std::string out = "$" + name + " << EOD\n";
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    out += format(series.x[i]) + " " + format(series.y[i]);
    if (has_interval(series)) out.append(" ").append(format(series.low[i])).append(" ").append(format(series.high[i]));
    out += "\n";
  }
  return out + "EOD\n";
}

std::string plot_of(const Series& series, const std::string& name) {
  const std::string colour =
      std::string(" lc rgb '") + kColours[static_cast<std::size_t>(series.colour) % kColours.size()] + "'";
  const std::string line = colour + " lw 2" + (series.dashed ? " dt 2" : "");
  const std::string title = " title " + quoted(series.label);
  std::string out;
  if (has_interval(series)) {
    out = series.bars ? "$" + name + " using 1:2:3:4 with yerrorbars pt 7 ps 0.6" + colour + " notitle, "
                      : "$" + name + " using 1:3:4 with filledcurves fs transparent solid 0.18 noborder" + colour +
                            " notitle, ";
  }
  return out + "$" + name + " using 1:2 with lines" + line + title;
}

std::string script(const Figure& figure) {
  std::string out = "set encoding utf8\nset grid lc rgb '#dddddd'\nset border 3 lc rgb '#666666'\nset tics nomirror\n";
  out += "set key outside below horizontal noenhanced\n";
  out += "set title " + quoted(figure.title) + " noenhanced\nset xlabel " + quoted(figure.x_label) +
         " noenhanced\nset ylabel " + quoted(figure.y_label) + " noenhanced\n";
  if (figure.y_low < figure.y_high) out += "set yrange [" + format(figure.y_low) + ":" + format(figure.y_high) + "]\n";
  std::string plots;
  for (std::size_t s = 0; s < figure.series.size(); ++s) {
    const std::string name = "s" + std::to_string(s);
    out += data_block(figure.series[s], name);
    plots += (s > 0 ? ", " : "plot ") + plot_of(figure.series[s], name);
  }
  out += "set terminal svg size 560,380 font 'DejaVu Sans,12' background rgb 'white'\nset output " +
         quoted(figure.name + ".svg") + "\n" + plots + "\n";
  return out + "set terminal pngcairo size 1120,760 fontscale 2 font 'DejaVu Sans,9'\nset output " +
         quoted(figure.name + ".png") + "\nreplot\n";
}

}  // namespace

std::string to_csv(const Figure& figure) {
  std::string out = "series,x,y,low,high\n";
  for (const auto& series : figure.series) {
    std::string label = series.label;
    std::replace(label.begin(), label.end(), ',', ';');
    std::replace(label.begin(), label.end(), '"', '\'');
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      out.append(label).append(",").append(format(series.x[i])).append(",").append(format(series.y[i])).append(",");
      out += has_interval(series) ? format(series.low[i]) + "," + format(series.high[i]) + "\n" : ",\n";
    }
  }
  return out;
}

Status draw(const Figure& figure, const fs::path& folder) {
  PRIMO_TRY(write_file(folder / (figure.name + ".csv"), to_csv(figure)));
  PRIMO_TRY(write_file(folder / (figure.name + ".gp"), script(figure)));
  const auto drawn = run_program({"gnuplot", figure.name + ".gp"}, folder);
  if (!drawn.ok()) return Error{Code::unavailable, drawn.error().message + "; Debian's package gnuplot-nox has it"};
  if (drawn->exit != 0) {
    return Error{Code::failed,
                 (folder / (figure.name + ".gp")).string() + ": gnuplot refuses it: " + drawn->output.substr(0, 400)};
  }
  return success();
}

}  // namespace primo::study

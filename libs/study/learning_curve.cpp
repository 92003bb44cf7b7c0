// The learning curve as SVG (paper, Figures 2 and 5).
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "study/html.h"

namespace primo::study::html {
namespace {

/// Best so far after each evaluation of one restart.
struct Course {
  std::vector<double> gamma, success;
};

/// Mean and standard error over restarts, after each evaluation.
struct Line {
  std::vector<double> mean, error;
};

/// A plot's frame: evaluations along x, values from `low` to `high` along y, in the viewBox of 520 × 300.
struct Frame {
  double evaluations = 1, low = 0, high = 1;
  static constexpr double kLeft = 44, kRight = 496, kTop = 14, kBottom = 262;
  double x(double n) const { return kLeft + (kRight - kLeft) * n / evaluations; }
  double y(double v) const { return kBottom - (kBottom - kTop) * (v - low) / (high - low); }
};

std::map<std::string, std::map<int, Course>> courses_of(const std::vector<EvaluationRecord>& evaluations) {
  std::map<std::string, std::map<int, Course>> courses;
  for (const auto& e : evaluations) {
    auto& course = courses[e.algorithm + (e.round > 0 ? ", round " + std::to_string(e.round + 1) : "")][e.restart];
    const double success = e.scenarios > 0 ? static_cast<double>(e.successes) / e.scenarios : 0;
    if (course.gamma.empty() || e.gamma > course.gamma.back()) {
      course.gamma.push_back(e.gamma);
      course.success.push_back(success);
    } else {
      course.gamma.push_back(course.gamma.back());
      course.success.push_back(course.success.back());
    }
  }
  return courses;
}

Line line_of(const std::map<int, Course>& restarts,
             const std::function<const std::vector<double>&(const Course&)>& values) {
  std::size_t length = 0;
  for (const auto& [restart, course] : restarts) length = std::max(length, values(course).size());
  Line line;
  for (std::size_t n = 0; n < length; ++n) {
    double sum = 0, squares = 0;
    for (const auto& [restart, course] : restarts) {
      const auto& v = values(course);
      const double value = v[std::min(n, v.size() - 1)];  // one that stopped early keeps its best
      sum += value;
      squares += value * value;
    }
    const double count = static_cast<double>(restarts.size());
    const double mean = sum / count;
    line.mean.push_back(mean);
    line.error.push_back(count > 1 ? std::sqrt(std::max(0.0, squares / count - mean * mean) / (count - 1)) : 0.0);
  }
  return line;
}

/// 1, 2 or 5 times a power of ten, about a fifth of the range.
double step_of(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 5)));
  const double parts = range / 5 / power;
  return (parts < 1.5 ? 1 : parts < 3.5 ? 2 : parts < 7.5 ? 5 : 10) * power;
}

std::string point(double x, double y) { return number("%.1f", x) + "," + number("%.1f", y); }

std::string axes(const Frame& frame, const std::string& title) {
  std::string out = "<svg viewBox=\"0 0 520 300\" role=\"img\" aria-label=\"" + escape(title) + "\">";
  const double step = step_of(frame.high - frame.low);
  for (double v = std::ceil(frame.low / step - 1e-9) * step; v <= frame.high + 1e-9; v += step) {
    const std::string y = number("%.1f", frame.y(v));
    out.append("<line class=\"axis\" x1=\"44\" x2=\"496\" y1=\"").append(y).append("\" y2=\"").append(y).append("\"/>");
    out.append("<text x=\"38\" y=\"").append(number("%.1f", frame.y(v) + 4)).append("\" text-anchor=\"end\">");
    out.append(number("%.3g", std::abs(v) < step / 2 ? 0.0 : v)).append("</text>");
  }
  const double each = std::max(1.0, step_of(frame.evaluations));
  for (double n = 0; n <= frame.evaluations + 1e-9; n += each) {
    out.append("<text x=\"").append(number("%.1f", frame.x(n))).append("\" y=\"280\" text-anchor=\"middle\">");
    out.append(number("%.0f", n)).append("</text>");
  }
  return out + "<text x=\"270\" y=\"297\" text-anchor=\"middle\">evaluations of γ</text>";
}

std::string draw(const Frame& frame, const Line& line, const std::string& colour) {
  // About a point a pixel.
  const std::size_t stride = std::max<std::size_t>(1, line.mean.size() / 460);
  std::string path, upper, lower;
  const auto add = [&](std::size_t n) {
    const double x = frame.x(static_cast<double>(n + 1));
    path.append(point(x, frame.y(line.mean[n]))).append(" ");
    upper.append(point(x, frame.y(std::min(frame.high, line.mean[n] + line.error[n])))).append(" ");
    lower.insert(0, point(x, frame.y(std::max(frame.low, line.mean[n] - line.error[n]))).append(" "));
  };
  for (std::size_t n = 0; n + 1 < line.mean.size(); n += stride) add(n);
  if (!line.mean.empty()) add(line.mean.size() - 1);
  std::string out = "<polygon fill=\"" + colour + "\" opacity=\"0.16\" points=\"";
  out.append(upper).append(lower).append("\"/><polyline class=\"line\" stroke=\"").append(colour);
  return out.append("\" points=\"").append(path).append("\"/>");
}

}  // namespace

Curves learning_curves(const std::vector<EvaluationRecord>& evaluations) {
  static constexpr const char* kColours[] = {"var(--a)", "var(--b)", "var(--c)", "var(--d)"};
  const auto courses = courses_of(evaluations);
  Frame success, gamma;
  gamma.low = 0;
  gamma.high = 0.1;
  for (const auto& [algorithm, restarts] : courses) {
    for (const auto& [restart, course] : restarts) {
      success.evaluations = std::max(success.evaluations, static_cast<double>(course.gamma.size()));
      gamma.low = std::min(gamma.low, course.gamma.front());
      gamma.high = std::max(gamma.high, course.gamma.back());
    }
  }
  success.high = 1.02;
  gamma.evaluations = success.evaluations;
  const double step = step_of(gamma.high - gamma.low);
  gamma.low = std::floor(gamma.low / step) * step;
  gamma.high = std::ceil(gamma.high / step + 1e-9) * step;
  Curves curves;
  curves.success = axes(success, "Success rate of the best candidate so far against evaluations");
  curves.gamma = axes(gamma, "γ of the best candidate so far against evaluations");
  std::size_t colour = 0;
  for (const auto& [algorithm, restarts] : courses) {
    const std::string stroke = kColours[colour++ % std::size(kColours)];
    curves.success += draw(success,
                           line_of(
                               restarts, [](const Course& c) -> const auto& { return c.success; }),
                           stroke);
    curves.gamma += draw(gamma,
                         line_of(
                             restarts, [](const Course& c) -> const auto& { return c.gamma; }),
                         stroke);
    curves.legend.append("<span><i style=\"background:").append(stroke).append("\"></i>").append(escape(algorithm));
    if (restarts.size() > 1)
      curves.legend.append(", mean of ").append(std::to_string(restarts.size())).append(" restarts");
    curves.legend += "</span>";
  }
  curves.success += "</svg>";
  curves.gamma += "</svg>";
  return curves;
}

}  // namespace primo::study::html

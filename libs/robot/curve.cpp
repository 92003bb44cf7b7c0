#include "robot/curve.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace primo::robot {

Curve::Curve(double first, double step, std::vector<double> values)
    : first_(first), step_(step), values_(std::move(values)), slopes_(values_.size()) {
  PRIMO_CHECK(values_.size() >= 3 && step > 0, "a curve needs three values and a step");
  const auto& y = values_;
  const std::size_t last = y.size() - 1;
  for (std::size_t k = 1; k < last; ++k) slopes_[k] = (y[k + 1] - y[k - 1]) / (2 * step_);
  slopes_[0] = (-3 * y[0] + 4 * y[1] - y[2]) / (2 * step_);
  slopes_[last] = (3 * y[last] - 4 * y[last - 1] + y[last - 2]) / (2 * step_);
}

Curve::Place Curve::place(double x) const {
  const double t = (x - first_) / step_;
  const auto k = static_cast<std::size_t>(std::clamp(std::floor(t), 0.0, static_cast<double>(values_.size() - 2)));
  return {k, t - static_cast<double>(k)};
}

double Curve::value(double x) const {
  const auto [k, s] = place(x);
  if (s < 0) return values_[k] + s * step_ * slopes_[k];
  if (s > 1) return values_[k + 1] + (s - 1) * step_ * slopes_[k + 1];
  const double rise = values_[k + 1] - values_[k], a = step_ * slopes_[k] - rise, b = rise - step_ * slopes_[k + 1];
  return values_[k] + s * rise + s * (1 - s) * ((1 - s) * a + s * b);
}

double Curve::slope(double x) const {
  const auto [k, s] = place(x);
  if (s < 0) return slopes_[k];
  if (s > 1) return slopes_[k + 1];
  const double rise = values_[k + 1] - values_[k], a = step_ * slopes_[k] - rise, b = rise - step_ * slopes_[k + 1];
  return (rise + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)) / step_;
}

double Curve::steepest() const {
  double most = 0;
  for (const double slope : slopes_) most = std::max(most, std::abs(slope));
  return most;
}

}  // namespace primo::robot

// A smooth function of one variable, given at evenly spaced places.
#pragma once

#include <vector>

namespace primo::robot {

/// Cubic Hermite interpolation with slopes by differences of second order: of a smooth function, values are right to
/// the third order of the spacing, slopes to the second. Straight beyond the ends.
class Curve {
 public:
  /// values[k] at first + k · step. @pre at least three values, step > 0.
  Curve(double first, double step, std::vector<double> values);
  double value(double x) const;
  double slope(double x) const;
  /// The largest |slope| at a given place.
  double steepest() const;

 private:
  struct Place {
    std::size_t k;
    double s;  // in units of the step, from the place's left end; outside [0, 1] beyond the curve's ends
  };
  Place place(double x) const;

  double first_, step_;
  std::vector<double> values_, slopes_;
};

}  // namespace primo::robot

#include "robot/curve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace primo::robot {
namespace {

Curve sampled(double (*f)(double), double first, double last, int parts) {
  std::vector<double> values;
  const double step = (last - first) / parts;
  for (int k = 0; k <= parts; ++k) values.push_back(f(first + k * step));
  return {first, step, values};
}

TEST(Curve, IsExactForParabolas) {
  const auto f = [](double x) { return 0.3 - 2 * x + 1.5 * x * x; };
  const Curve curve = sampled(+f, -1, 2, 5);
  for (double x = -1; x <= 2; x += 0.037) {
    EXPECT_NEAR(curve.value(x), f(x), 1e-12);
    EXPECT_NEAR(curve.slope(x), -2 + 3 * x, 1e-12);
  }
  EXPECT_NEAR(curve.steepest(), 5, 1e-12) << "at −1";
}

TEST(Curve, GainsThreeOrdersInValueAndTwoInSlope) {
  const auto error = [](int parts, bool slope) {
    const Curve curve = sampled(
        +[](double x) { return std::sin(x); }, 0, 3, parts);
    double worst = 0;
    for (double x = 0.5; x <= 2.5; x += 0.0137) {
      worst = std::max(worst, slope ? std::abs(curve.slope(x) - std::cos(x)) : std::abs(curve.value(x) - std::sin(x)));
    }
    return worst;
  };
  EXPECT_NEAR(error(16, false) / error(32, false), 8, 1);
  EXPECT_NEAR(error(16, true) / error(32, true), 4, 1);
}

TEST(Curve, GoesOnStraightBeyondItsEnds) {
  const Curve curve = sampled(
      +[](double x) { return x * x; }, 1, 2, 8);
  EXPECT_NEAR(curve.value(0.5), 1 - 0.5 * 2, 1e-12);
  EXPECT_NEAR(curve.value(3), 4 + 1 * 4, 1e-12);
  EXPECT_NEAR(curve.slope(-10), 2, 1e-12);
  EXPECT_NEAR(curve.slope(10), 4, 1e-12);
}

}  // namespace
}  // namespace primo::robot

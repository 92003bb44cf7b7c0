#include "physics/jiggle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace primo::physics {
namespace {

/// One-sided power spectral density of x at frequency f, from the transfer function: an Ornstein–Uhlenbeck acceleration
/// of variance s2 and rate kappa has density 4 s2 kappa/(kappa² + w²) per Hz, filtered by 1/(w0² − w² + 2 i ζ w0 w).
double density(double f, double f0, double s2) {
  const double w = 2 * std::numbers::pi * f, w0 = 2 * std::numbers::pi * f0, kappa = 3 * w0;
  const std::complex<double> denominator(w0 * w0 - w * w, 2 * 0.7 * w0 * w);
  return 4 * s2 * kappa / (kappa * kappa + w * w) / std::norm(denominator);
}

double integral(double from, double to, double f0, double s2) {
  double sum = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) sum += density(from + (to - from) * (i + 0.5) / n, f0, s2) * (to - from) / n;
  return sum;
}

TEST(BandLimitedProcess, has_the_rms_that_its_spectrum_integrates_to) {
  for (const double f0 : {2.0, 3.0, 4.0}) {
    const BandLimitedProcess process(f0, 0.012, 0.002);
    const double s2 = process.covariance()(2, 2);
    EXPECT_NEAR(std::sqrt(integral(0, 400, f0, s2)), 0.012, 1e-5) << f0;
    EXPECT_NEAR(std::sqrt(process.covariance()(0, 0)), 0.012, 1e-15);
  }
}

TEST(BandLimitedProcess, crosses_zero_as_often_as_its_band_says) {
  // Rice: a Gaussian process of spectrum S crosses zero 2 √(∫f²S / ∫S) times a second.
  const double f0 = 3.0, dt = 0.001, seconds = 500;
  double power = 0, second = 0;
  for (int i = 0; i < 400000; ++i) {
    const double f = (i + 0.5) * 0.001;
    power += density(f, f0, 1.0);
    second += f * f * density(f, f0, 1.0);
  }
  const double expected = 2 * std::sqrt(second / power);
  EXPECT_LT(expected, 2 * f0);  // band-limited: slower than its frequency
  const BandLimitedProcess process(f0, 0.012, dt);
  Random random(13, "test");
  Eigen::Vector3d z = process.draw(random);
  int crossings = 0;
  const int steps = static_cast<int>(seconds / dt);
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d next = process.step(z, random);
    crossings += (z[0] < 0) != (next[0] < 0);
    z = next;
  }
  EXPECT_NEAR(crossings / (steps * dt) / expected, 1.0, 0.05);
}

TEST(BandLimitedProcess, keeps_its_covariance_from_step_to_step_whatever_the_step) {
  for (const double dt : {0.0005, 0.002, 0.02}) {
    const BandLimitedProcess process(3.0, 0.012, dt);
    Random random(7, "test", {static_cast<std::uint64_t>(dt * 1e6)});
    Eigen::Vector3d z = process.draw(random);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    const int n = static_cast<int>(400 / dt);  // 400 s: about 2000 independent samples
    for (int i = 0; i < n; ++i) {
      z = process.step(z, random);
      sum += z * z.transpose() / n;
    }
    const Eigen::Matrix3d& C = process.covariance();
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(sum(i, i) / C(i, i), 1.0, 0.12) << "dt " << dt << " moment " << i;
    EXPECT_NEAR(sum(0, 1) / std::sqrt(C(0, 0) * C(1, 1)), 0, 0.05);
  }
}

TEST(BandLimitedProcess, has_the_acceleration_rms_of_the_closed_form) {
  // ⟨ẍ²⟩/(ω⁴⟨x²⟩) = 3.546 for κ = 3ω, ζ = .7, from the stationary moments: 12 mm at 3 Hz shakes with 8.0 m/s².
  const BandLimitedProcess process(3.0, 0.012, 0.002);
  Random random(11, "test");
  double sum = 0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double a = process.acceleration(process.draw(random));
    sum += a * a / n;
  }
  EXPECT_NEAR(std::sqrt(sum), 8.03, 0.12);
}

TEST(Shaker, begins_at_rest_and_is_the_same_for_the_same_seed) {
  Shaker a(5, 3, 0.012, 0.1, 0.002), b(5, 3, 0.012, 0.1, 0.002), c(6, 3, 0.012, 0.1, 0.002);
  const ShakerState start = a.next();
  EXPECT_EQ(start.omega.norm(), 0);
  EXPECT_EQ(start.acceleration.norm(), 0);
  b.next();
  c.next();
  bool differs = false;
  for (int i = 0; i < 500; ++i) {
    const ShakerState x = a.next(), y = b.next(), z = c.next();
    EXPECT_EQ(x.acceleration, y.acceleration);
    EXPECT_EQ(x.alpha, y.alpha);
    EXPECT_EQ(x.R_NP, y.R_NP);
    differs = differs || x.acceleration != z.acceleration;
  }
  EXPECT_TRUE(differs);
}

TEST(Shaker, angular_acceleration_is_the_rate_of_angular_velocity) {
  const double dt = 1e-5;
  Shaker shaker(3, 3, 0.012, 0.1, dt);
  Eigen::Vector3d omega = shaker.next().omega, integrated = Eigen::Vector3d::Zero();
  for (int i = 0; i < 40000; ++i) {  // 0.4 s: over the end of the fade
    const ShakerState state = shaker.next();
    integrated += state.alpha * dt;
    omega = state.omega;
  }
  EXPECT_LT((omega - integrated).norm(), 0.01 * omega.norm() + 1e-3);
}

}  // namespace
}  // namespace primo::physics

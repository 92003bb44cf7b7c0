#include "physics/jiggle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace primo::physics {
namespace {

constexpr double kDamping = 0.7;
constexpr double kCutOff = 3.0;  // correlation rate of the driving acceleration, in units of the natural frequency

/// exp(A) by scaling, a Taylor series and squaring.
Eigen::Matrix3d exponential(const Eigen::Matrix3d& A) {
  const double norm = A.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = norm > 0.25 ? static_cast<int>(std::ceil(std::log2(norm / 0.25))) : 0;
  const Eigen::Matrix3d scaled = A * std::ldexp(1.0, -squarings);
  Eigen::Matrix3d term = Eigen::Matrix3d::Identity(), sum = term;
  for (int k = 1; k <= 14; ++k) {
    term = term * scaled / k;
    sum += term;
  }
  for (int i = 0; i < squarings; ++i) sum = sum * sum;
  return sum;
}

/// L with L Lᵀ = C for a positive semi-definite C: a pivot lost to rounding counts as zero.
Eigen::Matrix3d root(const Eigen::Matrix3d& C) {
  Eigen::Matrix3d L = Eigen::Matrix3d::Zero();
  for (int j = 0; j < 3; ++j) {
    const double pivot = C(j, j) - L.row(j).head(j).squaredNorm();
    L(j, j) = pivot > 0 ? std::sqrt(pivot) : 0.0;
    for (int i = j + 1; i < 3; ++i) {
      L(i, j) = L(j, j) > 0 ? (C(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j) : 0.0;
    }
  }
  return L;
}

Eigen::Vector3d normals(Random& random) {
  Eigen::Vector3d n;
  for (int i = 0; i < 3; ++i) n[i] = random.normal();
  return n;
}

/// Fade-in s(t) with its first two derivatives: 10 u³ − 15 u⁴ + 6 u⁵.
Eigen::Vector3d fade(double time) {
  const double u = time / Shaker::kFadeSeconds;
  if (u >= 1) return {1, 0, 0};
  const double rate = 1 / Shaker::kFadeSeconds;
  return {u * u * u * (10 + u * (-15 + 6 * u)), rate * 30 * u * u * (1 - u) * (1 - u),
          rate * rate * 60 * u * (1 - u) * (1 - 2 * u)};
}

}  // namespace

BandLimitedProcess::BandLimitedProcess(double frequency, double rms, double dt)
    : omega_(2 * std::numbers::pi * frequency) {
  const double kappa = kCutOff * omega_;
  drift_ << 0, 1, 0, -omega_ * omega_, -2 * kDamping * omega_, 1, 0, 0, -kappa;
  // Stationary moments of the linear process, from setting d⟨·⟩/dt = 0: ⟨xa⟩ = σ²/(κ² + 2ζωκ + ω²), ⟨ẋa⟩ = κ⟨xa⟩, ⟨xẋ⟩
  // = 0, ⟨ẋ²⟩ = ⟨ẋa⟩/(2ζω), ⟨x²⟩ = (⟨ẋ²⟩ + ⟨xa⟩)/ω². Solved for σ² from ⟨x²⟩ = rms².
  const double xa = rms * rms * omega_ * omega_ / (kappa / (2 * kDamping * omega_) + 1);
  const double va = kappa * xa, vv = va / (2 * kDamping * omega_);
  const double aa = xa * (kappa * kappa + 2 * kDamping * omega_ * kappa + omega_ * omega_);
  covariance_ << rms * rms, 0, xa, 0, vv, va, xa, va, aa;
  transition_ = exponential(drift_ * dt);
  root_ = root(covariance_);
  noise_root_ = root(covariance_ - transition_ * covariance_ * transition_.transpose());
}

Eigen::Vector3d BandLimitedProcess::draw(Random& random) const { return root_ * normals(random); }

Eigen::Vector3d BandLimitedProcess::step(const Eigen::Vector3d& state, Random& random) const {
  return transition_ * state + noise_root_ * normals(random);
}

double BandLimitedProcess::acceleration(const Eigen::Vector3d& state) const { return drift_.row(1).dot(state); }

Shaker::Shaker(std::uint64_t seed, double frequency, double translation, double rotation, double dt)
    : random_(seed, "jiggle"), translation_(frequency, translation, dt), rotation_(frequency, rotation, dt), dt_(dt) {
  for (int i = 0; i < 6; ++i) states_.col(i) = (i < 3 ? translation_ : rotation_).draw(random_);
}

ShakerState Shaker::next() {
  if (!first_) {
    for (int i = 0; i < 6; ++i) states_.col(i) = (i < 3 ? translation_ : rotation_).step(states_.col(i), random_);
    time_ += dt_;
  }
  const Eigen::Vector3d s = fade(time_);
  ShakerState state;
  Eigen::Vector3d acceleration_N;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d& z = states_.col(i);
    const double second = (i < 3 ? translation_ : rotation_).acceleration(z);
    const double faded_rate = s[1] * z[0] + s[0] * z[1];
    const double faded_second = s[2] * z[0] + 2 * s[1] * z[1] + s[0] * second;
    if (i < 3) {
      acceleration_N[i] = faded_second;
    } else {
      state.omega[i - 3] = faded_rate;
      state.alpha[i - 3] = faded_second;
    }
  }
  if (!first_) {
    const double angle = state.omega.norm() * dt_;
    if (angle > 0) R_NP_ = R_NP_ * Eigen::AngleAxisd(angle, state.omega.normalized()).toRotationMatrix();
  }
  first_ = false;
  state.R_NP = R_NP_;
  state.acceleration = R_NP_.transpose() * acceleration_N;
  return state;
}

}  // namespace primo::physics

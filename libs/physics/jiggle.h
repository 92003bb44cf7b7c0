// The jiggle: six independent band-limited Brownian processes that shake a hand (paper, Sec. V: "jiggled with Brownian
// motion").
//
// Each process x is a spring-damper of natural frequency f and damping ratio ζ = 0.7 driven by an Ornstein–Uhlenbeck
// acceleration a of correlation rate κ = 3 · 2πf:   ẍ = a − 2ζω ẋ − ω² x,   da = −κ a dt + √(2κ) σ dW. σ is set so that
// x has the wanted rms. The step is the exact transition of the linear process, so the statistics do not depend on dt.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/random.h"

namespace primo::physics {

/// One scalar process in its stationary state.
class BandLimitedProcess {
 public:
  /// frequency in Hz, rms of x, step dt in s. All > 0, but rms may be 0.
  BandLimitedProcess(double frequency, double rms, double dt);

  /// State (x, ẋ, a) drawn from the stationary distribution, and one step dt later.
  Eigen::Vector3d draw(Random& random) const;
  Eigen::Vector3d step(const Eigen::Vector3d& state, Random& random) const;
  /// ẍ of a state.
  double acceleration(const Eigen::Vector3d& state) const;
  /// Stationary covariance of (x, ẋ, a), in closed form.
  const Eigen::Matrix3d& covariance() const { return covariance_; }

 private:
  double omega_ = 0;
  Eigen::Matrix3d drift_, transition_, covariance_, root_, noise_root_;
};

/// Motion of the hand's frame P against its nominal pose, at one instant. All vectors in P's axes. The acceleration is
/// that of the point the hand turns about; which point that is, the user says.
struct ShakerState {
  Eigen::Matrix3d R_NP = Eigen::Matrix3d::Identity();  ///< from P to the nominal frame N
  Eigen::Vector3d acceleration{0, 0, 0};               ///< of the centre of the turning, m/s²
  Eigen::Vector3d omega{0, 0, 0};                      ///< angular velocity of P, rad/s
  Eigen::Vector3d alpha{0, 0, 0};                      ///< angular acceleration of P, rad/s²
};

/// Six processes, three of translation and three of rotation about the axes of P, faded in over 0.2 s by a C²
/// polynomial. The rotation processes' rates are P's angular velocity, so the motion is an exact rigid motion.
class Shaker {
 public:
  /// translation: rms in m; rotation: rms in rad; the stream is keyed by `seed`.
  Shaker(std::uint64_t seed, double frequency, double translation, double rotation, double dt);
  /// The next instant, dt later; the first call gives time 0, at rest.
  ShakerState next();

  static constexpr double kFadeSeconds = 0.2;

 private:
  Random random_;
  BandLimitedProcess translation_, rotation_;
  double dt_, time_ = 0;
  bool first_ = true;
  Eigen::Matrix<double, 3, 6> states_;
  Eigen::Matrix3d R_NP_ = Eigen::Matrix3d::Identity();
};

}  // namespace primo::physics

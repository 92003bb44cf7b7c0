#include "motion/rotation_vector.h"

#include <Eigen/Geometry>
#include <cmath>

namespace primo::motion {

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  // θ = 2 atan2(sin θ/2, cos θ/2); θ / sin(θ/2) → 2 at 0.
  const double scale = sine < 1e-9 ? 2 / q.w() : 2 * std::atan2(sine, q.w()) / sine;
  return scale * q.vec();
}

Eigen::Matrix3d inverse_right_jacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  // 1/12 + θ²/720 + …; the closed form loses its digits as θ → 0.
  const double c =
      angle < 1e-3 ? 1.0 / 12 + angle * angle / 720 : (1 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  Eigen::Matrix3d cross;
  cross << 0, -phi.z(), phi.y(), phi.z(), 0, -phi.x(), -phi.y(), phi.x(), 0;
  return Eigen::Matrix3d::Identity() + 0.5 * cross + c * cross * cross;
}

}  // namespace primo::motion

// The logarithm of rotations: θ a, the angle times the unit axis.
#pragma once

#include <Eigen/Core>

namespace primo::motion {

/// φ with exp([φ]×) = R, |φ| in [0, π], rad. Accurate at 0 and at π; of the two vectors of a half turn it gives one.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// J_r⁻¹(φ) = I + ½ [φ]× + (1 − (θ/2) cot(θ/2)) / θ² [φ]×², θ = |φ| < 2π: log(exp(φ) exp(δ)) = φ + J_r⁻¹(φ) δ + O(δ²).
Eigen::Matrix3d inverse_right_jacobian(const Eigen::Vector3d& phi);

}  // namespace primo::motion

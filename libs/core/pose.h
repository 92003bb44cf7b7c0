// Poses X_AB: the pose of frame B measured and expressed in frame A. Metres and radians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace primo {

using Pose = Eigen::Isometry3d;

/// X_AB from B's origin in A and roll, pitch, yaw (about A's fixed x, then y, then z axes).
inline Pose pose(const Eigen::Vector3d& p_AB, const Eigen::Vector3d& rpy = Eigen::Vector3d::Zero()) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() =
      (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  X_AB.translation() = p_AB;
  return X_AB;
}

/// X_AB from B's origin in A and a quaternion, which is normalised.
inline Pose pose(const Eigen::Vector3d& p_AB, const Eigen::Quaterniond& q_AB) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() = q_AB.normalized().toRotationMatrix();
  X_AB.translation() = p_AB;
  return X_AB;
}

/// The quaternion of X_AB with w ≥ 0, so that one rotation has one form.
inline Eigen::Quaterniond quaternion(const Pose& X_AB) {
  Eigen::Quaterniond q(X_AB.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

}  // namespace primo

#include "robot/robot.h"

#include <cmath>

#include "core/check.h"

namespace primo::robot {

namespace {

/// R ← R · rotation about coordinate axis K by the angle of this cosine and sine: mixes the two other columns.
template <int K>
void turn(Eigen::Matrix3d& R, double c, double s) {
  constexpr int i = (K + 1) % 3, j = (K + 2) % 3;
  const Eigen::Vector3d column = R.col(i);
  R.col(i) = c * column + s * R.col(j);
  R.col(j) = c * R.col(j) - s * column;
}

/// R ← R · rotation by `angle` about the joint's axis.
void rotate(Eigen::Matrix3d& R, const ChainJoint& joint, double angle) {
  // Chains are mostly built of joints about a coordinate axis.
  if (joint.principal < 0) {
    R = R * Eigen::AngleAxisd(angle, joint.axis).toRotationMatrix();
    return;
  }
  const double c = std::cos(angle), s = joint.axis[joint.principal] * std::sin(angle);
  switch (joint.principal) {
    case 0:
      return turn<0>(R, c, s);
    case 1:
      return turn<1>(R, c, s);
    default:
      return turn<2>(R, c, s);
  }
}

}  // namespace

int Robot::body(const std::string& name) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

void Robot::forward(const Eigen::Ref<const Eigen::VectorXd>& q, Kinematics& out) const {
  PRIMO_CHECK(q.size() == joints(),
              "q has " + std::to_string(q.size()) + " entries, expected " + std::to_string(joints()));
  out.X_WB.resize(bodies_.size());
  out.anchor_W.resize(chain_.size());
  out.axis_W.resize(chain_.size());
  out.slope.resize(chain_.size());
  out.X_WB[0].setIdentity();
  for (std::size_t b = 1; b < bodies_.size(); ++b) {
    // Rotations and translations apart: products of Isometry3d would also multiply the constant last row.
    const Pose& X_WP = out.X_WB[bodies_[b].parent];
    Eigen::Vector3d p = X_WP.translation();
    p.noalias() += X_WP.linear() * X_PB_[b].translation();
    Eigen::Matrix3d R =
        turned_[b] ? Eigen::Matrix3d(X_WP.linear() * X_PB_[b].linear()) : Eigen::Matrix3d(X_WP.linear());
    for (int j = first_joint_[b]; j < first_joint_[b + 1]; ++j) {
      const ChainJoint& joint = chain_[j];
      const double displacement = joint.value(q[joint.index]) - joint.reference;
      out.slope[j] = joint.slope(q[joint.index]);
      if (joint.principal >= 0) {
        out.axis_W[j] = joint.axis[joint.principal] * R.col(joint.principal);
      } else {
        out.axis_W[j].noalias() = R * joint.axis;
      }
      out.anchor_W[j] = p;
      if (!joint.centred) out.anchor_W[j].noalias() += R * joint.anchor;
      if (joint.slide) {
        p += displacement * out.axis_W[j];
      } else {
        rotate(R, joint, displacement);
        if (!joint.centred) p.noalias() = out.anchor_W[j] - R * joint.anchor;
      }
    }
    Pose& X_WB = out.X_WB[b];
    X_WB.linear() = R;
    X_WB.translation() = p;
    X_WB.makeAffine();
  }
}

Kinematics Robot::forward(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  Kinematics kinematics;
  forward(q, kinematics);
  return kinematics;
}

void Robot::add_point_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W,
                               const Eigen::Vector3d& weight, Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (const int j : moving_[body]) {
    const ChainJoint& joint = chain_[j];
    const Eigen::Vector3d& axis = kinematics.axis_W[j];
    row[joint.index] +=
        kinematics.slope[j] * (joint.slide ? weight.dot(axis) : weight.dot(axis.cross(p_W - kinematics.anchor_W[j])));
  }
}

void Robot::add_vector_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& v_W,
                                const Eigen::Vector3d& weight, Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (const int j : moving_[body]) {
    const ChainJoint& joint = chain_[j];
    if (!joint.slide) row[joint.index] += kinematics.slope[j] * weight.dot(kinematics.axis_W[j].cross(v_W));
  }
}

void Robot::add_angular_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& weight,
                                 Eigen::Ref<Eigen::RowVectorXd> row) const {
  for (const int j : moving_[body]) {
    const ChainJoint& joint = chain_[j];
    if (!joint.slide) row[joint.index] += kinematics.slope[j] * weight.dot(kinematics.axis_W[j]);
  }
}

Eigen::Matrix3Xd Robot::point_jacobian(const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W) const {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, joints());
  for (const int j : moving_[body]) {
    const ChainJoint& joint = chain_[j];
    const Eigen::Vector3d& axis = kinematics.axis_W[j];
    if (joint.slide) {
      J.col(joint.index) += kinematics.slope[j] * axis;
    } else {
      J.col(joint.index) += kinematics.slope[j] * axis.cross(p_W - kinematics.anchor_W[j]);
    }
  }
  return J;
}

Eigen::Matrix3Xd Robot::vector_jacobian(const Kinematics& kinematics, int body, const Eigen::Vector3d& v_W) const {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, joints());
  for (const int j : moving_[body]) {
    const ChainJoint& joint = chain_[j];
    if (!joint.slide) J.col(joint.index) += kinematics.slope[j] * kinematics.axis_W[j].cross(v_W);
  }
  return J;
}

}  // namespace primo::robot

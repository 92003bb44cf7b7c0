// What predicates are computed from: bodies with their geometry and the hand's hold on them. Physics or perception
// fills it.
#pragma once

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

#include "core/pose.h"

namespace primo::symbols {

enum class BodyKind { table, cylinder, box };

/// A rigid body of the scene. Its frame B is at its centre; a cylinder's axis is z.
struct SnapshotBody {
  std::string name;
  BodyKind kind = BodyKind::cylinder;
  Pose X_WB = Pose::Identity();           ///< W: z up
  Eigen::Vector3d half_extents{0, 0, 0};  ///< m, in B; of a cylinder (radius, radius, half height)
};

struct WorldSnapshot {
  std::vector<SnapshotBody> bodies;
  std::set<std::string>
      in_hand;  ///< names of the bodies the hand holds: thumb and a finger touch them and nothing else carries them

  const SnapshotBody* body(const std::string& name) const;
};

/// Height of the body's highest and lowest point in W, m.
double top_height(const SnapshotBody& body);
double bottom_height(const SnapshotBody& body);
/// Whether the vertical line through p_W meets the body's shadow on the ground, approximated for a tilted body by the
/// box around it in W.
bool above_footprint(const SnapshotBody& body, const Eigen::Vector3d& p_W);

}  // namespace primo::symbols

// What perception makes of a scene: the objects and the table it found, and the occupancy map behind them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/pose.h"
#include "robot/shape.h"
#include "scene/scenario.h"

namespace primo::scene {

/// One depth image as points in the world frame.
struct PointCloud {
  Pose X_WC = Pose::Identity();         ///< camera pose: x right, y down, z forward
  std::vector<Eigen::Vector3f> points;  ///< m, in C; misses are left out
};

/// An object found in the points. Same conventions as Object.
struct ObjectEstimate {
  std::string name;  ///< the scenario's name where one was given to match, else o1, o2, …
  ShapeType type = ShapeType::cylinder;
  Pose X_WO = Pose::Identity();
  Shape shape;
  double residual = 0;  ///< m, rms distance of its points to the fitted surface
  int points = 0;       ///< support
};

struct SceneEstimate {
  std::string scene;  ///< scene_id of the scenario the clouds came from; empty on a live camera
  Table table;
  std::vector<ObjectEstimate> objects;  ///< in order of name
  std::vector<std::uint8_t> octree;     ///< OctoMap's binary stream (.bt payload); empty where none was asked for
  double resolution = 0.01;             ///< m, of the octree

  const ObjectEstimate* object(const std::string& name) const;
};

}  // namespace primo::scene

// Primitive collision shapes with MuJoCo's size conventions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "config/config.h"

namespace primo {

enum class ShapeType { sphere, capsule, cylinder, box };
template <>
struct config::EnumNames<ShapeType> {
  static constexpr std::array<std::string_view, 4> names = {"sphere", "capsule", "cylinder", "box"};
};

/// A shape in its own frame, centred at the origin; axes of capsules and cylinders along z.
struct Shape {
  ShapeType type = ShapeType::sphere;
  /// Metres. sphere: (r,·,·); capsule and cylinder: (r, half length, ·) without the caps; box: half extents.
  Eigen::Vector3d size{0, 0, 0};
};

}  // namespace primo

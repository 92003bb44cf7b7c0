// Gaps between the objects of a scenario, and whether they stand on its table.
#pragma once

#include "core/pose.h"
#include "robot/shape.h"
#include "scene/scenario.h"

namespace primo::scene {

/// The largest p·direction over the shape at X_WS: its support function. m.
double support(const Shape& shape, const Pose& X_WS, const Eigen::Vector3d& direction_W);

/// Whether the object's z axis is vertical, up or down, within 1e-6 rad.
bool upright(const Object& object);

/// Distance between two objects, negative when they overlap (then only the sign has a meaning). Exact between upright
/// objects, cylinders and boxes. Else a lower bound from separating axes: positive means certainly apart.
double gap(const Object& a, const Object& b);

/// Height of the object's lowest point over the table's top, m.
double height_over_table(const Object& object, const Table& table);

/// Whether the object's centre of mass is over the table's top.
bool centre_over_table(const Object& object, const Table& table);

}  // namespace primo::scene

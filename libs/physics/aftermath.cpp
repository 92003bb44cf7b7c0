#include "physics/aftermath.h"

#include <cmath>
#include <numbers>

#include "symbols/predicates.h"

namespace primo::physics {
namespace {

symbols::SnapshotBody* find(symbols::WorldSnapshot& world, const std::string& name) {
  for (auto& body : world.bodies) {
    if (body.name == name) return &body;
  }
  return nullptr;
}

}  // namespace

symbols::WorldSnapshot snapshot(const scene::Scenario& scenario) {
  symbols::WorldSnapshot world;
  const auto& table = scenario.table;
  world.bodies.push_back({table.name, symbols::BodyKind::table,
                          pose(table.top_centre - Eigen::Vector3d(0, 0, table.thickness / 2)),
                          Eigen::Vector3d(table.size.x() / 2, table.size.y() / 2, table.thickness / 2)});
  for (const auto& object : scenario.objects) {
    const bool cylinder = object.type == ShapeType::cylinder;
    world.bodies.push_back(
        {object.name, cylinder ? symbols::BodyKind::cylinder : symbols::BodyKind::box, object.X_WO(),
         cylinder ? Eigen::Vector3d(object.radius, object.radius, object.height / 2) : object.half_extents});
  }
  if (scenario.held) world.in_hand.insert(scenario.held->object);
  return world;
}

void lay_down(symbols::WorldSnapshot& world, const std::string& name) {
  auto* body = find(world, name);
  if (!body || body->kind == symbols::BodyKind::table) return;
  const double floor = symbols::bottom_height(*body);
  // Only what stands can fall; what lies already stays.
  if (std::abs(body->X_WB.linear()(2, 2)) < std::cos(symbols::kUprightTolerance)) return;
  body->X_WB.linear() =
      body->X_WB.linear() * Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  body->X_WB.translation().z() += floor - symbols::bottom_height(*body);
}

symbols::WorldSnapshot snapshot_after(const scene::Scenario& scenario, const std::string& target,
                                      const Aftermath& aftermath) {
  symbols::WorldSnapshot world = snapshot(scenario);
  if (aftermath.knocked) lay_down(world, *aftermath.knocked);
  auto* body = find(world, target);
  if (!body || !aftermath.X_WO_target) return world;
  if (aftermath.held) {
    world.in_hand.insert(target);
    body->X_WB = *aftermath.X_WO_target;
  } else if (aftermath.X_WO_target->linear().col(2).dot(body->X_WB.linear().col(2)) <
             std::cos(symbols::kUprightTolerance)) {
    lay_down(world, target);
  }
  return world;
}

}  // namespace primo::physics

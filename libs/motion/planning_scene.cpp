#include "motion/planning_scene.h"

#include <algorithm>

#include "robot/distance.h"
#include "scene/occupancy_map.h"

namespace primo::motion {
namespace {

Result<SceneBody> make_body(const std::string& name, const Shape& shape, const Pose& X_WB) {
  const bool has_second = shape.type == ShapeType::capsule || shape.type == ShapeType::cylinder;
  const int sizes = shape.type == ShapeType::box ? 3 : has_second ? 2 : 1;
  for (int i = 0; i < sizes; ++i) {
    if (!(shape.size[i] > 0 && shape.size[i] < 100)) {
      return Error{Code::data, "scene: '" + name + "' has size " + std::to_string(shape.size[i]) +
                                   " m; sizes must be above 0 and below 100 m"};
    }
  }
  if (!X_WB.matrix().allFinite() || X_WB.translation().norm() > 1e3) {
    return Error{Code::data, "scene: the pose of '" + name + "' is not finite and within 1 km of the robot"};
  }
  return SceneBody{name, shape, X_WB, robot::bounding_radius(shape)};
}

/// Voxels farther than this from everything occupied need no distance of their own, m: beyond the largest margin that a
/// task usually has, and bounded below by interpolate() outside.
constexpr double kRim = 0.12;

std::vector<Eigen::Vector3d> cut_out(std::vector<Eigen::Vector3d> voxels, const SceneBody& body, double reach) {
  const Pose X_BW = body.X_WB.inverse();
  std::erase_if(voxels, [&](const Eigen::Vector3d& p_W) {
    Eigen::Vector3d normal;
    return robot::signed_distance(body.shape, X_BW * p_W, normal) <= reach;
  });
  return voxels;
}

Result<std::shared_ptr<const scene::DistanceField>> make_field(const std::vector<Eigen::Vector3d>& occupied,
                                                               double resolution) {
  PRIMO_ASSIGN(auto field, scene::distance_field(occupied, resolution, kRim));
  return std::shared_ptr<const scene::DistanceField>(std::make_shared<scene::DistanceField>(std::move(field)));
}

}  // namespace

const SceneBody* PlanningScene::find(const std::string& name) const {
  if (name.empty()) return nullptr;
  if (name == target.name) return &target;
  if (held && name == held->name) return &*held;
  for (const auto& body : obstacles) {
    if (body.name == name) return &body;
  }
  return nullptr;
}

std::string PlanningScene::names() const {
  std::string all = target.name;
  if (held && !target_is_held()) all += ", " + held->name;
  for (const auto& body : obstacles) all += ", " + body.name;
  return all;
}

Result<PlanningScene> PlanningScene::create(const scene::SceneEstimate& estimate,
                                            const std::vector<std::string>& action,
                                            const std::optional<HeldObject>& held) {
  if (action.size() < 2) {
    return Error{Code::data, "action: '" + (action.empty() ? std::string() : action[0]) +
                                 "' has no argument; it must name its target object, e.g. [grasp, c1]"};
  }
  PlanningScene scene;
  bool found = false;
  std::string known;
  std::vector<const scene::ObjectEstimate*> objects;
  for (const auto& object : estimate.objects) objects.push_back(&object);
  std::stable_sort(objects.begin(), objects.end(), [](const auto* a, const auto* b) { return a->name < b->name; });
  for (const auto* object : objects) {
    PRIMO_ASSIGN(SceneBody body, make_body(object->name, object->shape, object->X_WO));
    known += (known.empty() ? "" : ", ") + object->name;
    const bool is_held = held && object->name == held->name && !scene.held;
    if (is_held) scene.held = body;
    if (object->name == action[1] && !found) {
      scene.target = std::move(body);
      found = true;
    } else if (!is_held) {
      scene.obstacles.push_back(std::move(body));
    }
  }
  if (known.empty()) known = "none";
  if (!found) {
    return Error{Code::data, "action: no object '" + action[1] + "' in the scene; its objects are " + known};
  }
  if (held) {
    if (!scene.held)
      return Error{Code::data, "held: no object '" + held->name + "' in the scene; its objects are " + known};
    if (!held->X_GO.matrix().allFinite() || held->X_GO.translation().norm() > 10) {
      return Error{Code::data,
                   "held: the pose of '" + held->name + "' in the grasp frame is not finite and within 10 m"};
    }
    scene.X_GO = held->X_GO;
  }
  const auto& table = estimate.table;
  const Shape box{ShapeType::box, {0.5 * table.size.x(), 0.5 * table.size.y(), 0.5 * table.thickness}};
  const Eigen::Vector3d centre = table.top_centre - Eigen::Vector3d(0, 0, 0.5 * table.thickness);
  PRIMO_ASSIGN(SceneBody table_body, make_body(table.name, box, pose(centre)));
  scene.obstacles.push_back(std::move(table_body));
  if (action.size() > 2) scene.second = action[2];
  return scene;
}

Status PlanningScene::perceive(const scene::SceneEstimate& estimate) {
  if (estimate.octree.empty()) {
    return Error{Code::data,
                 "scene: its octree is empty, and a task of the primitive needs the perceived occupancy map; send the "
                 "scene estimate with its octree"};
  }
  PRIMO_ASSIGN(const auto map, scene::OccupancyMap::from_bytes(estimate.octree));
  const double voxel = map.resolution();
  auto occupied = map.occupied();
  if (held) occupied = cut_out(std::move(occupied), *held, voxel);
  PRIMO_ASSIGN(perceived, make_field(occupied, voxel));
  perceived_without_contact = perceived;
  const auto* body = contact();
  if (!body) return success();
  const auto rest = cut_out(occupied, *body, voxel);
  if (rest.size() == occupied.size()) return success();
  PRIMO_ASSIGN(perceived_without_contact, make_field(rest, voxel));
  return success();
}

}  // namespace primo::motion

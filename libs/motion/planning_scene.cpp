#include "motion/planning_scene.h"

#include <algorithm>

#include "robot/distance.h"

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

}  // namespace

Result<PlanningScene> PlanningScene::create(const scene::SceneEstimate& estimate,
                                            const std::vector<std::string>& action) {
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
    if (object->name == action[1] && !found) {
      scene.target = std::move(body);
      found = true;
    } else {
      scene.obstacles.push_back(std::move(body));
    }
  }
  if (!found) {
    return Error{Code::data, "action: no object '" + action[1] + "' in the scene; its objects are " +
                                 (known.empty() ? "none" : known)};
  }
  const auto& table = estimate.table;
  const Shape box{ShapeType::box, {0.5 * table.size.x(), 0.5 * table.size.y(), 0.5 * table.thickness}};
  const Eigen::Vector3d centre = table.top_centre - Eigen::Vector3d(0, 0, 0.5 * table.thickness);
  PRIMO_ASSIGN(SceneBody table_body, make_body(table.name, box, pose(centre)));
  scene.obstacles.push_back(std::move(table_body));
  return scene;
}

}  // namespace primo::motion

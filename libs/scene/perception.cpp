#include "scene/perception.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "scene/object_estimation.h"
#include "scene/occupancy_map.h"

namespace primo::scene {
namespace {

constexpr std::size_t kMaxClouds = 16, kMaxPoints = 4'000'000, kMaxLabels = 256;
constexpr double kFarthest = 100;  // m

Error bad(const std::string& message) { return {Code::data, "perception: " + message}; }

Status check_cloud(const PointCloud& cloud, const std::string& place) {
  const Eigen::Matrix3d R = cloud.X_WC.linear();
  if (!cloud.X_WC.matrix().allFinite() || cloud.X_WC.translation().norm() > kFarthest ||
      !((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3) || !(R.determinant() > 0)) {
    return bad(place + ": the camera's pose is no finite rigid transform within 100 m");
  }
  bool good = true;  // all at once, as there are many points and hardly ever a wrong one
  for (const Eigen::Vector3f& p : cloud.points) {
    for (const float value : {p.x(), p.y(), p.z()}) good &= std::abs(value) <= static_cast<float>(kFarthest);
  }
  if (good) return success();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= static_cast<float>(kFarthest)) continue;
    return bad(place + ": point " + std::to_string(i) + " is not finite or farther than 100 m; leave misses out");
  }
  return success();
}

/// PerceptionSettings' own bounds, for requests that did not come from a file.
Status check_settings(PerceptionSettings settings) {
  std::string problem;
  const auto check = [&problem](const char* name, auto& value, const config::Field& field) {
    const auto number = static_cast<double>(value);
    if (problem.empty() && !(number >= field.min && number <= field.max)) {
      problem = std::string("setting '") + name + "' is out of its bounds: " + config::detail::format(number) +
                ", must be between " + config::detail::format(field.min) + " and " + config::detail::format(field.max);
    }
  };
  settings.visit(check);
  if (problem.empty() && settings.min_table_height >= settings.max_table_height) {
    problem = "setting 'min_table_height' must be below 'max_table_height'";
  }
  if (!problem.empty()) return bad(problem);
  return success();
}

Status check_request(const PerceptionRequest& request) {
  PRIMO_TRY(check_settings(request.settings));
  if (request.clouds.empty() || request.clouds.size() > kMaxClouds) {
    return bad(std::to_string(request.clouds.size()) + " clouds, must be 1 … " + std::to_string(kMaxClouds));
  }
  std::size_t points = 0;
  for (const auto& cloud : request.clouds) points += cloud.points.size();
  if (points == 0) return bad("the clouds hold no points; is the camera's view empty?");
  if (points > kMaxPoints) {
    return bad(std::to_string(points) + " points, must be at most " + std::to_string(kMaxPoints));
  }
  for (std::size_t i = 0; i < request.clouds.size(); ++i) {
    PRIMO_TRY(check_cloud(request.clouds[i], "cloud " + std::to_string(i)));
  }
  if (request.labels.size() > kMaxLabels) {
    return bad(std::to_string(request.labels.size()) + " labels, must be at most " + std::to_string(kMaxLabels));
  }
  std::set<std::string> names;
  for (const auto& label : request.labels) {
    if (label.name.empty() || !label.position.allFinite()) return bad("a label has no name or no finite position");
    if (!names.insert(label.name).second) return bad("label '" + label.name + "' is given twice");
  }
  if (!std::isfinite(request.lowest)) return bad("the lowest height is not finite");
  if (request.held && (names.contains(request.held->name) || !request.held->X_WO.matrix().allFinite())) {
    return bad("the held object '" + request.held->name + "' is also a label, or its pose is not finite");
  }
  return success();
}

/// Nearest pairs first; a label names at most one object. The others are numbered in order of x, then y.
void name_objects(const PerceptionRequest& request, std::vector<ObjectEstimate>& objects) {
  std::sort(objects.begin(), objects.end(), [](const ObjectEstimate& a, const ObjectEstimate& b) {
    const Eigen::Vector3d pa = a.X_WO.translation(), pb = b.X_WO.translation();
    return std::lexicographical_compare(pa.data(), pa.data() + 3, pb.data(), pb.data() + 3);
  });
  struct Pair {
    double distance;
    std::size_t label, object;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < request.labels.size(); ++i) {
    for (std::size_t j = 0; j < objects.size(); ++j) {
      const double d = (request.labels[i].position - objects[j].X_WO.translation()).head<2>().norm();
      if (d <= request.settings.match_distance) pairs.push_back({d, i, j});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  std::set<std::string> taken = {request.table};
  for (const auto& label : request.labels) taken.insert(label.name);
  if (request.held) taken.insert(request.held->name);
  std::vector<bool> used(request.labels.size(), false);
  for (const auto& pair : pairs) {
    if (used[pair.label] || !objects[pair.object].name.empty()) continue;
    used[pair.label] = true;
    objects[pair.object].name = request.labels[pair.label].name;
  }
  int number = 0;
  for (auto& object : objects) {
    while (object.name.empty()) {
      std::string name = "o";
      name += std::to_string(++number);
      if (taken.insert(name).second) object.name = name;
    }
  }
  if (request.held) objects.push_back(*request.held);
  std::sort(objects.begin(), objects.end(),
            [](const ObjectEstimate& a, const ObjectEstimate& b) { return a.name < b.name; });
}

Region region_of(const Table& table) {
  const Eigen::Vector3d half(table.size.x() / 2 + 0.1, table.size.y() / 2 + 0.1, 0);
  Region region{table.top_centre - half, table.top_centre + half};
  region.lower.z() -= 0.06;
  region.upper.z() += 0.5;
  return region;
}

}  // namespace

const ObjectEstimate* SceneEstimate::object(const std::string& name) const {
  for (const auto& candidate : objects) {
    if (candidate.name == name) return &candidate;
  }
  return nullptr;
}

std::vector<Label> labels_of(const Scenario& scenario) {
  std::vector<Label> labels;
  for (const auto& object : scenario.objects) {
    if (!scenario.holds(object.name)) labels.push_back({object.name, object.position});
  }
  return labels;
}

double lowest_of_interest(const Scenario& scenario) {
  constexpr double kMargin = 0.05;  // for the noise of cameras
  return std::max(0.0, scenario.table.top_centre.z() - scenario.table.thickness - kMargin);
}

PerceptionRequest perception_request(const Scenario& scenario, std::vector<PointCloud> clouds,
                                     const PerceptionSettings& settings) {
  PerceptionRequest request{scene_id(scenario), std::move(clouds), labels_of(scenario), scenario.table.name, settings};
  request.lowest = lowest_of_interest(scenario);
  const Object* held = scenario.held ? scenario.object(scenario.held->object) : nullptr;
  if (held) request.held = ObjectEstimate{held->name, held->type, held->X_WO(), held->shape()};
  return request;
}

Result<SceneEstimate> perceive(const PerceptionRequest& request) {
  PRIMO_TRY(check_request(request));
  std::size_t count = 0;
  for (const auto& cloud : request.clouds) count += cloud.points.size();
  // Lower points belong to no table, and can't be near one.
  const double floor = std::max(request.settings.min_table_height - kTableReach, request.lowest);
  Points points;
  points.reserve(count);
  for (const auto& cloud : request.clouds) {
    for (const auto& p_C : cloud.points) {
      const Eigen::Vector3d p_W = cloud.X_WC * p_C.cast<double>();
      if (p_W.z() >= floor) points.push_back(p_W);
    }
  }
  auto table = estimate_table(points, request.settings);
  if (!table.ok()) return table.error().at("perception");
  SceneEstimate estimate;
  estimate.scene = request.scene;
  estimate.table = table->table;
  estimate.table.name = request.table;
  estimate.objects = estimate_objects(points, *table, request.settings);
  name_objects(request, estimate.objects);
  estimate.resolution = request.settings.resolution;
  if (request.octree) {
    estimate.octree = OccupancyMap(request.clouds, region_of(estimate.table), request.settings.resolution).to_bytes();
  }
  return estimate;
}

Result<SceneEstimate> perceive(const std::vector<PointCloud>& clouds, const PerceptionSettings& settings) {
  return perceive(PerceptionRequest{"", clouds, {}, "table", settings});
}

Status require_objects(const SceneEstimate& estimate, const std::vector<std::string>& names) {
  for (const auto& name : names) {
    if (estimate.object(name)) continue;
    std::string found;
    for (const auto& object : estimate.objects) found += (found.empty() ? "" : ", ") + object.name;
    return Error{Code::failed, "object " + name + " was not found in the points: found " +
                                   (found.empty() ? "none" : found) + "; it must be in view and stand on the table"};
  }
  return success();
}

}  // namespace primo::scene

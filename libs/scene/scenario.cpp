#include "scene/scenario.h"

#include <cmath>
#include <set>

#include "core/hash.h"
#include "scene/geometry.h"

namespace primo::scene {
namespace {

constexpr double kRestTolerance = 1e-3;  // m, between an object's lowest point and the table's top
constexpr std::size_t kMaxObjects = 64, kMaxCameras = 8, kMaxJoints = 64;

std::string text(double value) { return config::detail::format(value); }

/// Checks values that are already in a struct against the bounds of its fields: scenarios also come over the wire.
class BoundsChecker {
 public:
  explicit BoundsChecker(std::string place, std::string& problem) : place_(std::move(place)), problem_(problem) {}

  template <class T>
  void operator()(const char* name, T& value, const config::Field& field = {}) {
    const std::string key = place_.empty() ? name : place_ + "." + name;
    if constexpr (config::detail::IsOptional<T>::value) {
      if (value) (*this)(name, *value, field);
    } else if constexpr (config::Visitable<T>) {
      BoundsChecker inner(key, problem_);
      value.visit(inner);
    } else if constexpr (config::EigenVector<T>) {
      for (int i = 0; i < T::RowsAtCompileTime; ++i) check(key + "[" + std::to_string(i) + "]", value(i), field);
    } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      check(key, static_cast<double>(value), field);
    } else if constexpr (config::detail::IsVector<T>::value) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        (*this)((std::string(name) + "[" + std::to_string(i) + "]").c_str(), value[i], field);
      }
    }
  }

 private:
  void check(const std::string& key, double value, const config::Field& field) {
    if (!problem_.empty() || (value >= field.min && value <= field.max && std::isfinite(value))) return;
    problem_ = "'" + key + "' is " + text(value) + ", must be finite";
    if (!std::isinf(field.min)) problem_ += ", at least " + text(field.min);
    if (!std::isinf(field.max)) problem_ += ", at most " + text(field.max);
    if (!field.unit.empty()) problem_ += " " + field.unit;
  }
  std::string place_;
  std::string& problem_;
};

Error refuse(const std::string& message) { return {Code::config, message}; }

Status check_bounds(const Scenario& scenario) {
  if (scenario.objects.size() > kMaxObjects) {
    return refuse("'objects' has " + std::to_string(scenario.objects.size()) + " entries, must be at most " +
                  std::to_string(kMaxObjects));
  }
  if (scenario.cameras.size() > kMaxCameras) {
    return refuse("'cameras' has " + std::to_string(scenario.cameras.size()) + " entries, must be at most " +
                  std::to_string(kMaxCameras));
  }
  if (scenario.robot_start.size() > kMaxJoints) {
    return refuse("'robot_start' has " + std::to_string(scenario.robot_start.size()) + " entries, must be at most " +
                  std::to_string(kMaxJoints));
  }
  std::string problem;
  BoundsChecker checker("", problem);
  Scenario copy = scenario;
  copy.visit(checker);
  if (!problem.empty()) return refuse(problem);
  return success();
}

/// Names become symbols: lower-case first letter, since variables of rules begin with a capital.
Status check_name(const std::string& what, const std::string& name) {
  bool good = !name.empty() && name.size() <= 64 && name[0] >= 'a' && name[0] <= 'z';
  for (const char c : name) {
    good = good && ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_');
  }
  if (good) return success();
  return refuse(
      what + " is named '" + name.substr(0, 80) +
      "'; a name begins with a lower-case letter and has at most 64 letters, digits and underscores, e.g. c1");
}

Status check_names(const Scenario& scenario) {
  PRIMO_TRY(check_name("the table", scenario.table.name));
  std::set<std::string> names = {scenario.table.name};
  for (const auto& object : scenario.objects) {
    PRIMO_TRY(check_name("an object", object.name));
    if (object.name == "world" || object.name == "floor") {
      return refuse("object '" + object.name + "': this name is taken by the world itself; give it another");
    }
    if (!names.insert(object.name).second) {
      return refuse("object '" + object.name + "': the name is given twice; names must be unique in a scenario");
    }
  }
  return success();
}

Status check_objects(const Scenario& scenario) {
  if (scenario.objects.empty()) return refuse("'objects' is empty; a scenario has at least one object");
  for (const auto& object : scenario.objects) {
    if (object.type != ShapeType::cylinder && object.type != ShapeType::box) {
      return refuse("object '" + object.name + "': 'type' is " + config::enum_name(object.type) +
                    ", must be cylinder or box");
    }
    const double height = height_over_table(object, scenario.table);
    if (scenario.holds(object.name)) {
      if (height > 0) continue;
      return refuse("object '" + object.name + "': it is held " + text(std::round(-height * 1e6) / 1e6) +
                    " m deep in the table, must be above its top");
    }
    if (std::abs(height) > kRestTolerance) {
      return refuse("object '" + object.name + "': its lowest point is " + text(std::round(height * 1e6) / 1e6) +
                    " m over the table's top, must rest on it (within 0.001 m): position[2] would be " +
                    text(object.position.z() - height));
    }
    if (!centre_over_table(object, scenario.table)) {
      return refuse("object '" + object.name + "': its centre (" + text(object.position.x()) + ", " +
                    text(object.position.y()) + ") is beyond the table's edge; it would fall off");
    }
  }
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = gap(scenario.objects[i], scenario.objects[j]);
      if (distance > 0) continue;
      return refuse("objects '" + scenario.objects[j].name + "' and '" + scenario.objects[i].name + "' overlap by " +
                    text(std::round(-distance * 1e6) / 1e6) + " m; move them apart");
    }
  }
  return success();
}

Status check_held(const Scenario& scenario) {
  if (!scenario.held) return success();
  if (!scenario.object(scenario.held->object)) {
    return refuse("'held.object' is '" + scenario.held->object.substr(0, 80) + "', must be an object of the scenario");
  }
  if (scenario.robot_start.empty()) {
    return refuse("'held' needs 'robot_start': the joint angles at which the hand holds '" + scenario.held->object +
                  "'");
  }
  return success();
}

/// The hand must be free for a grasp, and holds what is to be placed.
Status check_hand(const Scenario& scenario) {
  const auto& action = scenario.action;
  if (action[0] == "grasp" && scenario.held) {
    return refuse("'action' grasp needs a free hand, but it holds '" + scenario.held->object + "'; leave 'held' out");
  }
  if (action[0] != "place") return success();
  if (!scenario.holds(action[1])) {
    return refuse("'action' place: the hand does not hold '" + action[1] + "'; 'held' must say {object: " + action[1] +
                  ", position: …, rpy: …}");
  }
  if (action[1] == action[2]) return refuse("'action' places '" + action[1] + "' on itself");
  return success();
}

Status check_action(const Scenario& scenario) {
  if (scenario.action.empty() || scenario.action[0].empty()) {
    return refuse("'action' is empty, must be a name and its arguments, e.g. [grasp, c1]");
  }
  const std::string& name = scenario.action[0];
  PRIMO_TRY(check_name("the action", name));
  if (name == "grasp" && scenario.action.size() != 2) {
    return refuse("'action' grasp has " + std::to_string(scenario.action.size() - 1) +
                  " arguments, must have one: the object, e.g. [grasp, c1]");
  }
  if (name == "place" && scenario.action.size() != 3) {
    return refuse("'action' place has " + std::to_string(scenario.action.size() - 1) +
                  " arguments, must have two: the held object and its support, e.g. [place, c1, c2]");
  }
  for (std::size_t i = 1; i < scenario.action.size(); ++i) {
    const std::string& argument = scenario.action[i];
    if (scenario.object(argument) || (i > 1 && argument == scenario.table.name)) continue;
    std::string known;
    for (const auto& object : scenario.objects) known += (known.empty() ? "" : ", ") + object.name;
    return refuse("'action' names '" + argument.substr(0, 80) + "', which is no object of the scenario; objects are " +
                  known);
  }
  return check_hand(scenario);
}

Status check_cameras(const Scenario& scenario) {
  for (std::size_t i = 0; i < scenario.cameras.size(); ++i) {
    if ((scenario.cameras[i].look_at - scenario.cameras[i].position).norm() < 0.01) {
      return refuse("'cameras[" + std::to_string(i) + "]': 'look_at' is at the camera itself, must be elsewhere");
    }
  }
  return success();
}

}  // namespace

Shape Object::shape() const {
  if (type == ShapeType::box) return {ShapeType::box, half_extents};
  return {type, {radius, height / 2, 0}};
}

const Object* Scenario::object(const std::string& object_name) const {
  for (const auto& candidate : objects) {
    if (candidate.name == object_name) return &candidate;
  }
  return nullptr;
}

Status Scenario::validate() const {
  PRIMO_TRY(check_bounds(*this));
  PRIMO_TRY(check_names(*this));
  PRIMO_TRY(check_held(*this));
  PRIMO_TRY(check_objects(*this));
  PRIMO_TRY(check_action(*this));
  return check_cameras(*this);
}

std::vector<Camera> default_cameras(const Table& table, double depth_noise) {
  std::vector<Camera> cameras(2);
  for (int i = 0; i < 2; ++i) {
    Camera& camera = cameras[static_cast<std::size_t>(i)];
    camera.position = table.top_centre + Eigen::Vector3d(0, i == 0 ? -0.7 : 0.7, 0.85);
    camera.look_at = table.top_centre + Eigen::Vector3d(0, 0, 0.03);
    camera.depth_noise = depth_noise;
  }
  return cameras;
}

Result<Scenario> read_scenario_text(const std::string& yaml, const std::string& where) {
  PRIMO_ASSIGN(Scenario scenario, config::read_text<Scenario>(yaml, where));
  if (scenario.cameras.empty()) scenario.cameras = default_cameras(scenario.table);
  return scenario;
}

Result<Scenario> read_scenario(const std::filesystem::path& path) {
  PRIMO_ASSIGN(const std::string yaml, read_file(path));
  return read_scenario_text(yaml, path.string());
}

Status write_scenario(const std::filesystem::path& path, const Scenario& scenario) {
  return write_file(path, config::dump(scenario));
}

std::string scene_id(const Scenario& scenario) {
  Scenario content = scenario;
  content.name.clear();
  if (content.cameras.empty()) content.cameras = default_cameras(content.table);
  return content_id(config::dump(content));
}

}  // namespace primo::scene

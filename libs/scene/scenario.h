// A scenario: the true scene, the robot's start and the action to try there. What scenario files (YAML) hold.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/pose.h"
#include "core/result.h"
#include "robot/shape.h"

namespace primo::scene {

/// A movable object: an upright or lying cylinder or a box. World frame W: z up, origin at the robot base's centre on
/// the floor.
struct Object {
  std::string name;
  ShapeType type = ShapeType::cylinder;            ///< cylinder or box
  double radius = 0.0375;                          ///< m, cylinders
  double height = 0.108;                           ///< m, cylinders: full height
  Eigen::Vector3d half_extents{0.03, 0.03, 0.05};  ///< m, boxes
  Eigen::Vector3d position{0.8, 0.0, 0.724};       ///< p_WO: the object's centre, m
  Eigen::Vector3d rpy{0, 0, 0};                    ///< rad
  double mass = 0.3;                               ///< kg

  Shape shape() const;
  Pose X_WO() const { return pose(position, rpy); }
  template <class V>
  void visit(V&& v);
};

/// A box-shaped table whose top is level.
struct Table {
  std::string name = "table";
  Eigen::Vector3d top_centre{0.8, 0.0, 0.67};  ///< m, centre of the top surface in W
  Eigen::Vector2d size{0.52, 0.52};            ///< m, along x and y
  double thickness = 0.04;                     ///< m
  template <class V>
  void visit(V&& v);
};

/// A pinhole depth camera.
struct Camera {
  Eigen::Vector3d position{0.8, -0.9, 1.35};  ///< m in W
  Eigen::Vector3d look_at{0.8, 0.0, 0.70};    ///< m in W
  double fov_y = 0.8;                         ///< rad, vertical
  int width = 320, height = 240;              ///< pixels
  double depth_noise = 0.0;                   ///< m, standard deviation along the ray
  template <class V>
  void visit(V&& v);
};

/// What the hand holds at the start: one of the scenario's objects, fixed in the grasp frame G of the robot file.
struct Held {
  std::string object;
  Eigen::Vector3d position{0, 0, 0};  ///< p_GO: the object's centre in the grasp frame, m
  Eigen::Vector3d rpy{0, 0, 0};       ///< rad

  Pose X_GO() const { return pose(position, rpy); }
  template <class V>
  void visit(V&& v);
};

struct Scenario {
  std::string name;
  Table table;
  std::vector<Object> objects;
  std::vector<Camera> cameras;      ///< empty: default_cameras()
  std::vector<double> robot_start;  ///< rad, in the robot file's joint order; empty: the robot file's home
  std::vector<std::string> action;  ///< e.g. [grasp, c1]
  std::uint64_t camera_seed = 0;    ///< seeds the depth noise
  std::optional<Held> held;  ///< its pose among `objects` is the one at robot_start; check_robot() holds both together

  /// The object of this name, or nullptr.
  const Object* object(const std::string& object_name) const;
  /// Whether the hand holds the object of this name.
  bool holds(const std::string& object_name) const { return held && held->object == object_name; }
  /// Sizes, names, overlap, objects on the table, action arguments: what can be checked without a robot.
  Status validate() const;
  template <class V>
  void visit(V&& v);
};

/// Two cameras that look at the table's middle from its left and right, high enough to see over small obstacles.
std::vector<Camera> default_cameras(const Table& table, double depth_noise = 0);

/// Reads and validates a scenario file, or its text; `where` names it in errors. Cameras left out are
/// default_cameras().
Result<Scenario> read_scenario(const std::filesystem::path& path);
Result<Scenario> read_scenario_text(const std::string& text, const std::string& where);

/// Writes a scenario with all its fields, so that read_scenario() gives the same back.
Status write_scenario(const std::filesystem::path& path, const Scenario& scenario);

/// 16 hex digits over the scenario's whole content but its name: the key of the scene in topics and journals.
std::string scene_id(const Scenario& scenario);

template <class V>
void Object::visit(V&& v) {
  v("name", name, {.help = "unique in the scenario", .required = true});
  v("type", type, {.help = "cylinder or box"});
  v("radius", radius, {.help = "cylinders", .unit = "m", .min = 0.005, .max = 0.5});
  v("height", height, {.help = "cylinders", .unit = "m", .min = 0.005, .max = 1});
  v("half_extents", half_extents, {.help = "boxes", .unit = "m", .min = 0.0025, .max = 1});
  v("position", position, {.help = "the centre, in the world", .unit = "m", .min = -5, .max = 5, .required = true});
  v("rpy", rpy, {.help = "roll, pitch, yaw about fixed axes", .unit = "rad", .min = -7, .max = 7});
  v("mass", mass, {.unit = "kg", .min = 0.001, .max = 50});
}

template <class V>
void Held::visit(V&& v) {
  v("object", object, {.help = "name of an object", .required = true});
  v("position", position, {.help = "its centre in the grasp frame", .unit = "m", .min = -1, .max = 1});
  v("rpy", rpy, {.help = "roll, pitch, yaw about the grasp frame's axes", .unit = "rad", .min = -7, .max = 7});
}

template <class V>
void Table::visit(V&& v) {
  v("name", name, {});
  v("top_centre", top_centre, {.unit = "m", .min = -5, .max = 5});
  v("size", size, {.help = "along x and y", .unit = "m", .min = 0.05, .max = 5});
  v("thickness", thickness, {.unit = "m", .min = 0.005, .max = 0.5});
}

template <class V>
void Camera::visit(V&& v) {
  v("position", position, {.unit = "m", .min = -10, .max = 10});
  v("look_at", look_at, {.unit = "m", .min = -10, .max = 10});
  v("fov_y", fov_y, {.help = "vertical field of view", .unit = "rad", .min = 0.05, .max = 2.5});
  v("width", width, {.unit = "px", .min = 8, .max = 1280});
  v("height", height, {.unit = "px", .min = 8, .max = 1024});
  v("depth_noise", depth_noise, {.help = "standard deviation along the ray", .unit = "m", .min = 0, .max = 0.1});
}

template <class V>
void Scenario::visit(V&& v) {
  v("name", name, {.required = true});
  v("table", table, {});
  v("objects", objects, {.required = true});
  v("cameras", cameras, {});
  v("robot_start", robot_start, {.help = "joint angles; empty: the robot's home", .unit = "rad", .min = -7, .max = 7});
  v("action", action, {.help = "name and arguments, e.g. [grasp, c1]", .required = true});
  v("camera_seed", camera_seed, {.help = "seeds the depth noise"});
  v("held", held, {.help = "what the hand holds at robot_start"});
}

}  // namespace primo::scene

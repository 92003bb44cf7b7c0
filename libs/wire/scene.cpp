#include "wire/check.h"
#include "wire/parts.h"
#include "wire/wire.h"

namespace primo::wire {
namespace {

// Beside the overloads below, not hidden by them.
using wire::from_wire;
using wire::to_wire;

msg::SceneObject to_wire(const scene::Object& object) {
  msg::SceneObject out;
  out.name(object.name);
  out.type(static_cast<std::uint8_t>(object.type));
  out.radius(object.radius);
  out.height(object.height);
  out.half_extents(to_vector(object.half_extents));
  out.position(to_point(object.position));
  out.rpy(to_vector(object.rpy));
  out.mass(object.mass);
  return out;
}

Result<scene::Object> from_wire(const std::string& field, const msg::SceneObject& object) {
  scene::Object out;
  out.name = object.name();
  PRIMO_ASSIGN(out.type, enum_from<ShapeType>(field + ".type", object.type()));
  out.radius = object.radius();
  out.height = object.height();
  out.half_extents = from_vector(object.half_extents());
  out.position = from_point(object.position());
  out.rpy = from_vector(object.rpy());
  out.mass = object.mass();
  return out;
}

msg::DepthCamera to_wire(const scene::Camera& camera) {
  msg::DepthCamera out;
  out.position(to_point(camera.position));
  out.look_at(to_point(camera.look_at));
  out.fov_y(camera.fov_y);
  out.width(static_cast<std::uint32_t>(camera.width));
  out.height(static_cast<std::uint32_t>(camera.height));
  out.depth_noise(camera.depth_noise);
  return out;
}

scene::Camera from_wire(const msg::DepthCamera& camera) {
  scene::Camera out;
  out.position = from_point(camera.position());
  out.look_at = from_point(camera.look_at());
  out.fov_y = camera.fov_y();
  out.width = static_cast<int>(std::min<std::uint32_t>(camera.width(), 1u << 30));
  out.height = static_cast<int>(std::min<std::uint32_t>(camera.height(), 1u << 30));
  out.depth_noise = camera.depth_noise();
  return out;
}

msg::ObjectEstimate to_wire(const scene::ObjectEstimate& object) {
  msg::ObjectEstimate out;
  out.name(object.name);
  out.type(static_cast<std::uint8_t>(object.type));
  out.pose(to_wire(object.X_WO));
  out.shape(to_wire(object.shape));
  out.residual(object.residual);
  out.points(object.points);
  return out;
}

Result<scene::ObjectEstimate> from_wire(const std::string& field, const msg::ObjectEstimate& object) {
  scene::ObjectEstimate out;
  PRIMO_TRY(check_text(field + ".name", object.name()));
  out.name = object.name();
  PRIMO_ASSIGN(out.type, enum_from<ShapeType>(field + ".type", object.type()));
  PRIMO_ASSIGN(out.X_WO, from_wire(field + ".pose", object.pose()));
  PRIMO_ASSIGN(out.shape, from_wire(field + ".shape", object.shape()));
  PRIMO_TRY(check_finite(field + ".residual", object.residual()));
  out.residual = object.residual();
  out.points = object.points();
  return out;
}

}  // namespace

msg::Scenario to_wire(const scene::Scenario& scenario) {
  msg::Scenario out;
  out.name(scenario.name);
  out.table(to_wire(scenario.table));
  for (const scene::Object& object : scenario.objects) out.objects().push_back(to_wire(object));
  for (const scene::Camera& camera : scenario.cameras) out.cameras().push_back(to_wire(camera));
  out.robot_start(scenario.robot_start);
  out.action(scenario.action);
  out.camera_seed(scenario.camera_seed);
  if (scenario.held) {
    msg::SceneHeld held;
    held.object(scenario.held->object);
    held.position(to_point(scenario.held->position));
    held.rpy(to_vector(scenario.held->rpy));
    out.held().push_back(std::move(held));
  }
  return out;
}

Result<scene::Scenario> from_wire(const msg::Scenario& message) {
  scene::Scenario out;
  out.name = message.name();
  PRIMO_ASSIGN(out.table, from_wire("scenario.table", message.table()));
  PRIMO_TRY(check_count("scenario.objects", message.objects().size()));
  for (const msg::SceneObject& object : message.objects()) {
    PRIMO_ASSIGN(scene::Object converted, from_wire("scenario.objects", object));
    out.objects.push_back(std::move(converted));
  }
  PRIMO_TRY(check_count("scenario.cameras", message.cameras().size(), 100));
  for (const msg::DepthCamera& camera : message.cameras()) out.cameras.push_back(from_wire(camera));
  out.robot_start = message.robot_start();
  out.action = message.action();
  out.camera_seed = message.camera_seed();
  PRIMO_TRY(check_count("scenario.held", message.held().size(), 1));
  for (const msg::SceneHeld& held : message.held()) {
    out.held = scene::Held{held.object(), from_point(held.position()), from_vector(held.rpy())};
  }
  PRIMO_TRY(check_fields("scenario", out));
  return out;
}

msg::PointCloud to_wire(const scene::PointCloud& cloud) {
  msg::PointCloud out;
  out.pose(to_wire(cloud.X_WC));
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  if (const std::size_t n = 3 * cloud.points.size(); n > 0) {
    const float* first = cloud.points.front().data();
    out.points().assign(first, first + n);
  }
  return out;
}

Result<scene::PointCloud> from_wire(const msg::PointCloud& message) {
  scene::PointCloud out;
  PRIMO_ASSIGN(out.X_WC, from_wire("cloud.pose", message.pose()));
  if (message.points().size() % 3 != 0) {
    return malformed("cloud.points",
                     "has " + std::to_string(message.points().size()) + " entries, expected x, y, z for each point");
  }
  PRIMO_TRY(check_finite("cloud.points", message.points()));
  out.points.resize(message.points().size() / 3);
  for (std::size_t i = 0; i < out.points.size(); ++i) out.points[i] = Eigen::Vector3f(&message.points()[3 * i]);
  return out;
}

msg::SceneEstimate to_wire(const scene::SceneEstimate& estimate) {
  msg::SceneEstimate out;
  out.scene(estimate.scene);
  out.table(to_wire(estimate.table));
  for (const scene::ObjectEstimate& object : estimate.objects) out.objects().push_back(to_wire(object));
  out.octree(estimate.octree);
  out.resolution(estimate.resolution);
  return out;
}

Result<scene::SceneEstimate> from_wire(const msg::SceneEstimate& message) {
  scene::SceneEstimate out;
  PRIMO_TRY(check_text("estimate.scene", message.scene()));
  out.scene = message.scene();
  PRIMO_ASSIGN(out.table, from_wire("estimate.table", message.table()));
  PRIMO_TRY(check_count("estimate.objects", message.objects().size()));
  for (const msg::ObjectEstimate& object : message.objects()) {
    PRIMO_ASSIGN(scene::ObjectEstimate converted, from_wire("estimate.objects", object));
    out.objects.push_back(std::move(converted));
  }
  PRIMO_TRY(check_count("estimate.octree", message.octree().size(), kMaxNumbers));
  out.octree = message.octree();
  if (!(message.resolution() > 0 && message.resolution() <= 1))
    return malformed("estimate.resolution", "must be in (0, 1] m");
  out.resolution = message.resolution();
  return out;
}

}  // namespace primo::wire

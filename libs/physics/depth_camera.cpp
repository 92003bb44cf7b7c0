#include "physics/depth_camera.h"

#include <cmath>

#include "core/random.h"
#include "physics/model.h"

namespace primo::physics {
namespace {

using Eigen::Vector3d;

/// Which groups rays see: the scene, not the robot.
constexpr mjtByte kSeen[mjNGROUP] = {1, 1, 0, 0, 0, 0};
static_assert(kFixtureGroup == 0 && kObjectGroup == 1 && kRobotGroup == 2);

scene::PointCloud render(const Model& model, const Data& data, const scene::Camera& camera, std::uint64_t seed,
                         std::uint64_t number, double range) {
  scene::PointCloud cloud;
  cloud.X_WC = camera_pose(camera);
  cloud.points.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  const double focal = camera.height / 2.0 / std::tan(camera.fov_y / 2);  // in pixels
  const Eigen::Matrix3d R_WC = cloud.X_WC.linear();
  const Vector3d origin = cloud.X_WC.translation();
  for (int row = 0; row < camera.height; ++row) {
    Random noise(seed, "depth", {number, static_cast<std::uint64_t>(row)});
    for (int column = 0; column < camera.width; ++column) {
      // Drawn for every pixel, so that a pixel's noise doesn't depend on what its neighbours hit.
      const double error = camera.depth_noise > 0 ? camera.depth_noise * noise.normal() : 0.0;
      const Vector3d ray_C =
          Vector3d((column + 0.5 - camera.width / 2.0) / focal, (row + 0.5 - camera.height / 2.0) / focal, 1)
              .normalized();
      const Vector3d ray_W = R_WC * ray_C;
      int geom = -1;
      const double hit = mj_ray(model.get(), data.get(), origin.data(), ray_W.data(), kSeen, 1, -1, &geom);
      const double depth = hit + error;
      if (hit < 0 || hit > range || depth <= 0) continue;
      cloud.points.push_back((depth * ray_C).cast<float>());
    }
  }
  return cloud;
}

}  // namespace

Pose camera_pose(const scene::Camera& camera) {
  const Vector3d z = (camera.look_at - camera.position).normalized();
  Vector3d x = z.cross(Vector3d::UnitZ());
  x = x.norm() < 1e-6 ? Vector3d::UnitX() : Vector3d(x.normalized());
  Pose X_WC = Pose::Identity();
  X_WC.linear().col(0) = x;
  X_WC.linear().col(1) = z.cross(x).normalized();
  X_WC.linear().col(2) = z;
  X_WC.translation() = camera.position;
  return X_WC;
}

Result<std::vector<scene::PointCloud>> render_depth(const scene::Scenario& scenario, double range) {
  if (auto status = scenario.validate(); !status.ok()) return status.error().at("scenario " + scenario.name);
  if (!(range > 0)) return Error{Code::config, "depth camera: the range must be a positive number of metres"};
  // Filtered out with the robot: what its hand holds.
  scene::Scenario seen = scenario;
  std::erase_if(seen.objects, [&](const scene::Object& object) { return scenario.holds(object.name); });
  PRIMO_ASSIGN(const Model model, assemble(nullptr, seen));
  Data data(model);
  mj_kinematics(model.get(), data.get());
  const auto cameras = scenario.cameras.empty() ? scene::default_cameras(scenario.table) : scenario.cameras;
  std::vector<scene::PointCloud> clouds;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    clouds.push_back(render(model, data, cameras[i], scenario.camera_seed, i, range));
  }
  return clouds;
}

}  // namespace primo::physics

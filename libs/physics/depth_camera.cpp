#include "physics/depth_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "physics/model.h"

namespace primo::physics {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Which groups rays see: the scene, not the robot.
constexpr mjtByte kSeen[mjNGROUP] = {1, 1, 0, 0, 0, 0};
static_assert(kFixtureGroup == 0 && kObjectGroup == 1 && kRobotGroup == 2);

/// m; points of the floor, which is at z = 0, are rounded to less.
constexpr double kFloorError = 1e-3;

/// The pixels whose rays can meet a geom: rows and columns from first to last.
struct Window {
  int geom = 0;
  int first_row = 0, last_row = 0, first_column = 0, last_column = 0;
};

double focal_length(const scene::Camera& camera) {  // in pixels
  return camera.height / 2.0 / std::tan(camera.fov_y / 2);
}

/// Where the geom's bounding box lies in the picture; the whole picture for what has none or reaches behind the camera.
Window window_of(const Model& model, const Data& data, const scene::Camera& camera, const Pose& X_WC, int geom) {
  Window window{geom, 0, camera.height - 1, 0, camera.width - 1};
  const Eigen::Map<const Vector3d> size(model->geom_size + 3 * geom);
  Vector3d half = size;
  if (model->geom_type[geom] == mjGEOM_CYLINDER) {
    half = {size[0], size[0], size[1]};
  } else if (model->geom_type[geom] != mjGEOM_BOX) {
    return window;
  }
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> R_WG(data->geom_xmat + 9 * geom);
  const Eigen::Map<const Vector3d> p_WG(data->geom_xpos + 3 * geom);
  const double focal = focal_length(camera);
  Eigen::AlignedBox2d picture;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vector3d p_C = X_WC.inverse(Eigen::Isometry) * (p_WG + R_WG * half.cwiseProduct(sign));
    if (p_C.z() < 1e-3) return window;
    picture.extend(focal * p_C.head<2>() / p_C.z() + Vector2d(camera.width, camera.height) / 2);
  }
  // A pixel more on each side than the projection of a convex shape needs. Clamped before it is an integer.
  const auto pixel = [](double at, int count) { return static_cast<int>(std::clamp(at, -1.0, count + 1.0)); };
  window.first_row = std::max(0, pixel(picture.min().y() - 1, camera.height) - 1);
  window.last_row = std::min(camera.height - 1, pixel(picture.max().y() + 1, camera.height));
  window.first_column = std::max(0, pixel(picture.min().x() - 1, camera.width) - 1);
  window.last_column = std::min(camera.width - 1, pixel(picture.max().x() + 1, camera.width));
  return window;
}

std::vector<Window> windows(const Model& model, const Data& data, const scene::Camera& camera, const Pose& X_WC) {
  std::vector<Window> all;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (kSeen[model->geom_group[geom]] != 0) all.push_back(window_of(model, data, camera, X_WC, geom));
  }
  return all;
}

/// What mj_ray() would answer: the distance to the nearest geom of the windows that hold the column, −1 for none.
double cast(const Model& model, const Data& data, const std::vector<Window>& row, int column, const Vector3d& origin,
            const Vector3d& ray_W) {
  double nearest = -1;
  for (const auto& window : row) {
    if (column < window.first_column || column > window.last_column) continue;
    const int g = window.geom;
    const double hit = mju_rayGeom(data->geom_xpos + 3 * g, data->geom_xmat + 9 * g, model->geom_size + 3 * g,
                                   origin.data(), ray_W.data(), model->geom_type[g]);
    if (hit >= 0 && (hit < nearest || nearest < 0)) nearest = hit;
  }
  return nearest;
}

scene::PointCloud render(const Model& model, const Data& data, const scene::Camera& camera, std::uint64_t seed,
                         std::uint64_t number, const DepthSettings& settings) {
  scene::PointCloud cloud;
  cloud.X_WC = camera_pose(camera);
  const double focal = focal_length(camera);
  const Eigen::Matrix3d R_WC = cloud.X_WC.linear();
  const Vector3d origin = cloud.X_WC.translation();
  const bool noisy = camera.depth_noise > 0;
  auto all = windows(model, data, camera, cloud.X_WC);
  if (!noisy && settings.lowest > kFloorError) {
    std::erase_if(all, [&](const Window& window) { return model->geom_type[window.geom] == mjGEOM_PLANE; });
  }
  std::vector<Window> in_row;
  for (int row = 0; row < camera.height; ++row) {
    in_row.clear();
    for (const auto& window : all) {
      if (row >= window.first_row && row <= window.last_row) in_row.push_back(window);
    }
    // Drawn for every pixel, so that a pixel's noise doesn't depend on what its neighbours hit.
    int first = noisy ? 0 : camera.width, last = noisy ? camera.width - 1 : -1;
    for (const auto& window : in_row) {
      first = std::min(first, window.first_column);
      last = std::max(last, window.last_column);
    }
    Random noise(seed, "depth", {number, static_cast<std::uint64_t>(row)});
    for (int column = first; column <= last; ++column) {
      // Through the middle of the pixel, in C.
      const Vector3d ray =
          Vector3d((column + 0.5 - camera.width / 2.0) / focal, (row + 0.5 - camera.height / 2.0) / focal, 1)
              .normalized();
      const double error = noisy ? camera.depth_noise * noise.normal() : 0.0;
      const double hit = cast(model, data, in_row, column, origin, R_WC * ray);
      const double depth = hit + error;
      if (hit < 0 || hit > settings.range || depth <= 0) continue;
      const Eigen::Vector3f point = (depth * ray).cast<float>();
      if (settings.lowest > 0 && (cloud.X_WC * point.cast<double>()).z() < settings.lowest) continue;
      cloud.points.push_back(point);
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

Result<std::vector<scene::PointCloud>> render_depth(const scene::Scenario& scenario, const DepthSettings& settings) {
  if (auto status = scenario.validate(); !status.ok()) return status.error().at("scenario " + scenario.name);
  if (!(settings.range > 0)) return Error{Code::config, "depth camera: the range must be a positive number of metres"};
  if (!std::isfinite(settings.lowest)) return Error{Code::data, "depth camera: the lowest height must be finite"};
  // Filtered out with the robot: what its hand holds.
  scene::Scenario seen = scenario;
  std::erase_if(seen.objects, [&](const scene::Object& object) { return scenario.holds(object.name); });
  PRIMO_ASSIGN(const Model model, assemble(nullptr, seen, {.moves = false, .extra = {}}));
  Data data(model);
  mj_kinematics(model.get(), data.get());
  const auto cameras = scenario.cameras.empty() ? scene::default_cameras(scenario.table) : scenario.cameras;
  std::vector<scene::PointCloud> clouds;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    clouds.push_back(render(model, data, cameras[i], scenario.camera_seed, i, settings));
  }
  return clouds;
}

}  // namespace primo::physics

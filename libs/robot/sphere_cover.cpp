#include "robot/sphere_cover.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"

namespace primo::robot {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

int pieces(double length, double longest) { return std::max(1, static_cast<int>(std::ceil(length / longest - 1e-9))); }

std::vector<Sphere> cover_capsule(double r, double half, double tolerance) {
  const double R = r + tolerance;
  const int gaps = pieces(2 * half, 2 * std::sqrt(R * R - r * r));
  // The radius that the actual spacing asks for: no more than R.
  const double tight = std::hypot(r, half / gaps);
  std::vector<Sphere> spheres;
  for (int i = 0; i <= gaps; ++i) spheres.push_back({Vector3d(0, 0, -half + 2 * half * i / gaps), tight});
  return spheres;
}

/// A sphere about a cell of edges d sticks out of the face across edge i by |d|/2 − d_i/2.
void cover_box(const Vector3d& half, double tolerance, std::vector<Sphere>& spheres) {
  Vector3i n;
  Vector3d d;
  for (double edge = 2 * half.maxCoeff();; edge *= 0.9) {
    for (int i = 0; i < 3; ++i) n[i] = pieces(2 * half[i], edge);
    d = 2 * half.cwiseQuotient(n.cast<double>());
    if (0.5 * (d.norm() - d.minCoeff()) <= tolerance) break;
  }
  const bool hollow = n.minCoeff() > 2;
  for (int x = 0; x < n.x(); ++x) {
    for (int y = 0; y < n.y(); ++y) {
      for (int z = 0; z < n.z(); ++z) {
        const Vector3i cell(x, y, z);
        if (hollow && cell.minCoeff() > 0 && (n - cell).minCoeff() > 1) continue;
        spheres.push_back({(cell.cast<double>().array() + 0.5).matrix().cwiseProduct(d) - half, 0.5 * d.norm()});
      }
    }
  }
  if (hollow) cover_box(half - d, tolerance + d.minCoeff(), spheres);
}

/// A cylinder cut into layers, rings and equal sectors: cell (r1 … r2, ±α, height d) in the sphere about the middle of
/// its radii at angle 0. The distance to that centre grows with the angle and is convex in the radius, so that a corner
/// is farthest.
struct Ring {
  double centre = 0, radius = 0;  // m: of the sphere's centre from the axis, and the sphere's own
  int sectors = 1;
};

Ring make_ring(double r1, double r2, double edge, double height) {
  if (r1 <= 0) return {0, std::hypot(r2, 0.5 * height), 1};
  Ring ring;
  ring.centre = 0.5 * (r1 + r2);
  ring.sectors = std::max(3, pieces(2 * std::numbers::pi * r2, edge));
  const double alpha = std::numbers::pi / ring.sectors, c = ring.centre;
  double farthest = 0;
  for (const double r : {r1, r2}) farthest = std::max(farthest, r * r + c * c - 2 * r * c * std::cos(alpha));
  ring.radius = std::sqrt(farthest + 0.25 * height * height);
  return ring;
}

void cover_cylinder(double r, double half, double tolerance, std::vector<Sphere>& spheres) {
  int layers = 1, rings = 1;
  for (double edge = 2 * std::max(r, half);; edge *= 0.9) {
    layers = pieces(2 * half, edge);
    rings = pieces(r, edge);
    const double d = 2 * half / layers;
    bool within = true;
    for (int k = 0; k < rings && within; ++k) {
      const Ring ring = make_ring(r * k / rings, r * (k + 1) / rings, edge, d);
      within = ring.radius - 0.5 * d <= tolerance && ring.centre + ring.radius - r <= tolerance;
    }
    if (!within) continue;
    const bool hollow = layers > 2 && rings > 1;
    for (int layer = 0; layer < layers; ++layer) {
      const bool outer_layer = !hollow || layer == 0 || layer == layers - 1;
      for (int k = outer_layer ? 0 : rings - 1; k < rings; ++k) {
        const Ring ring = make_ring(r * k / rings, r * (k + 1) / rings, edge, d);
        for (int s = 0; s < ring.sectors; ++s) {
          const double angle = 2 * std::numbers::pi * s / ring.sectors;
          spheres.push_back(
              {{ring.centre * std::cos(angle), ring.centre * std::sin(angle), -half + (layer + 0.5) * d}, ring.radius});
        }
      }
    }
    const double width = r / rings;
    if (hollow) cover_cylinder(r - width, half - d, tolerance + std::min(width, d), spheres);
    return;
  }
}

}  // namespace

std::vector<Sphere> sphere_cover(const Shape& shape, double tolerance) {
  PRIMO_CHECK(tolerance > 0 && shape.size[0] > 0, "a cover needs a positive tolerance and positive sizes");
  std::vector<Sphere> spheres;
  switch (shape.type) {
    case ShapeType::sphere:
      spheres.push_back({Vector3d::Zero(), shape.size[0]});
      break;
    case ShapeType::capsule:
      spheres = cover_capsule(shape.size[0], shape.size[1], tolerance);
      break;
    case ShapeType::cylinder:
      cover_cylinder(shape.size[0], shape.size[1], tolerance, spheres);
      break;
    case ShapeType::box:
      cover_box(shape.size, tolerance, spheres);
      break;
  }
  return spheres;
}

}  // namespace primo::robot

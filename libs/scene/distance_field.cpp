#include "scene/distance_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace primo::scene {
namespace {

constexpr float kFar = 1e20F;
constexpr double kMaxVoxels = 1 << 26;

/// The lower envelope of parabolas on one line of n voxels: squared distances and the voxel they come from.
class LineTransform {
 public:
  explicit LineTransform(int longest)
      : apex_(static_cast<std::size_t>(longest)),
        begin_(static_cast<std::size_t>(longest) + 1),
        value_(static_cast<std::size_t>(longest)),
        source_(static_cast<std::size_t>(longest)) {}

  /// In place on n entries `stride` apart. Lines with nothing occupied stay as they are.
  void run(float* squared, std::uint32_t* nearest, int n, std::size_t stride) {
    int k = -1;
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      value_[at] = squared[at * stride];
      source_[at] = nearest[at * stride];
      if (value_[at] >= kFar) continue;
      double left = -std::numeric_limits<double>::infinity();
      while (k >= 0 && (left = crossing(i, apex_[static_cast<std::size_t>(k)])) <= begin_[static_cast<std::size_t>(k)])
        --k;
      if (k < 0) left = -std::numeric_limits<double>::infinity();
      ++k;
      apex_[static_cast<std::size_t>(k)] = i;
      begin_[static_cast<std::size_t>(k)] = left;
    }
    if (k < 0) return;
    int j = 0;
    for (int i = 0; i < n; ++i) {
      while (j < k && begin_[static_cast<std::size_t>(j) + 1] < i) ++j;
      const int from = apex_[static_cast<std::size_t>(j)];
      const auto offset = static_cast<float>(i - from);
      squared[static_cast<std::size_t>(i) * stride] = offset * offset + value_[static_cast<std::size_t>(from)];
      nearest[static_cast<std::size_t>(i) * stride] = source_[static_cast<std::size_t>(from)];
    }
  }

 private:
  /// Where the parabola with apex at i begins to lie below the one with apex at j < i.
  double crossing(int i, int j) const {
    const double fi = value_[static_cast<std::size_t>(i)], fj = value_[static_cast<std::size_t>(j)];
    return ((fi + static_cast<double>(i) * i) - (fj + static_cast<double>(j) * j)) / (2.0 * (i - j));
  }
  std::vector<int> apex_;
  std::vector<double> begin_;
  std::vector<float> value_;
  std::vector<std::uint32_t> source_;
};

}  // namespace

Result<DistanceField> DistanceField::build(const std::vector<Eigen::Vector3d>& occupied, const Region& region,
                                           double resolution) {
  const Eigen::Vector3d extent = region.upper - region.lower;
  if (!(resolution > 0) || !extent.allFinite() || !(extent.minCoeff() > 0) ||
      !((extent / resolution).array().ceil().prod() <= kMaxVoxels)) {
    return Error{Code::data,
                 "distance field: needs a region with volume, a resolution above 0 and at most 2^26 voxels"};
  }
  DistanceField field;
  field.origin_ = region.lower;
  field.resolution_ = resolution;
  field.size_ = (extent / resolution - Eigen::Vector3d::Constant(1e-6)).array().ceil().cast<int>().max(1);
  const auto nx = static_cast<std::size_t>(field.size_.x()), ny = static_cast<std::size_t>(field.size_.y()),
             nz = static_cast<std::size_t>(field.size_.z());
  field.squared_.assign(nx * ny * nz, kFar);
  field.nearest_.assign(nx * ny * nz, 0);
  for (const auto& p : occupied) {
    if (!p.allFinite() || !region.contains(p)) continue;
    const std::size_t i = field.index(p);
    field.squared_[i] = 0;
    field.nearest_[i] = static_cast<std::uint32_t>(i);
    field.empty_ = false;
  }
  // z runs fastest in memory.
  LineTransform line(field.size_.maxCoeff());
  for (std::size_t i = 0; i < nx * ny; ++i)
    line.run(&field.squared_[i * nz], &field.nearest_[i * nz], field.size_.z(), 1);
  for (std::size_t x = 0; x < nx; ++x) {
    for (std::size_t z = 0; z < nz; ++z) {
      const std::size_t at = x * ny * nz + z;
      line.run(&field.squared_[at], &field.nearest_[at], field.size_.y(), nz);
    }
  }
  for (std::size_t i = 0; i < ny * nz; ++i) line.run(&field.squared_[i], &field.nearest_[i], field.size_.x(), ny * nz);
  return field;
}

std::size_t DistanceField::index(const Eigen::Vector3d& p_W) const {
  std::size_t at = 0;
  for (int i = 0; i < 3; ++i) {
    const double voxel = std::floor((p_W[i] - origin_[i]) / resolution_);
    const double last = size_[i] - 1;
    at = at * static_cast<std::size_t>(size_[i]) + static_cast<std::size_t>(voxel >= 0 ? std::min(voxel, last) : 0.0);
  }
  return at;
}

double DistanceField::distance(const Eigen::Vector3d& p_W) const {
  return empty_ ? infinite_distance() : std::sqrt(static_cast<double>(squared_[index(p_W)])) * resolution_;
}

double DistanceField::trilinear(const Eigen::Vector3d& voxels, Eigen::Vector3d& gradient) const {
  std::size_t at = 0;
  std::array<std::size_t, 3> step{};
  Eigen::Vector3d f;  // in [0, 1], from the cell's lower corner
  for (int i = 0; i < 3; ++i) {
    const int low = std::clamp(static_cast<int>(voxels[i]), 0, std::max(0, size_[i] - 2));
    f[i] = voxels[i] - low;
    at = at * static_cast<std::size_t>(size_[i]) + static_cast<std::size_t>(low);
    step[static_cast<std::size_t>(i)] = size_[i] > 1 ? 1 : 0;
  }
  const auto ny = static_cast<std::size_t>(size_.y()), nz = static_cast<std::size_t>(size_.z());
  step[0] *= ny * nz;
  step[1] *= nz;
  std::array<float, 8> d{};  // x, y, z as bits 4, 2, 1
  for (std::size_t k = 0; k < 8; ++k)
    d[k] = std::sqrt(squared_[at + (k >> 2) * step[0] + (k >> 1 & 1) * step[1] + (k & 1) * step[2]]);
  const auto along = [](double low, double high, double share) { return low + share * (high - low); };
  // One axis after the other: z, then y, then x.
  const double d00 = along(d[0], d[1], f.z()), d01 = along(d[2], d[3], f.z()), d10 = along(d[4], d[5], f.z()),
               d11 = along(d[6], d[7], f.z());
  const double d0 = along(d00, d01, f.y()), d1 = along(d10, d11, f.y());
  const auto slope_z = [&](std::size_t k) { return static_cast<double>(d[k + 1]) - d[k]; };
  gradient.x() = d1 - d0;
  gradient.y() = along(d01 - d00, d11 - d10, f.x());
  gradient.z() = along(along(slope_z(0), slope_z(2), f.y()), along(slope_z(4), slope_z(6), f.y()), f.x());
  return along(d0, d1, f.x()) * resolution_;
}

double DistanceField::interpolate(const Eigen::Vector3d& p_W, Eigen::Vector3d& gradient) const {
  gradient.setZero();
  if (empty_) return infinite_distance();
  const Eigen::Vector3d voxels = ((p_W - origin_) / resolution_).array() - 0.5;
  const Eigen::Vector3d last = (size_.array() - 1).cast<double>();
  const Eigen::Vector3d inside = voxels.cwiseMax(0).cwiseMin(last);
  const double d = trilinear(inside, gradient);
  const Eigen::Vector3d out = (voxels - inside) * resolution_;
  const double e = out.norm();
  if (e == 0) return d;
  const double length = std::sqrt(e * e + d * d);
  // Along the axes in which p is outside, the closest point does not move.
  for (int i = 0; i < 3; ++i) gradient[i] = (out[i] != 0 ? out[i] : d * gradient[i]) / length;
  return length;
}

Eigen::Vector3d DistanceField::closest(const Eigen::Vector3d& p_W) const {
  PRIMO_CHECK(!empty_, "the distance field has no occupied voxel");
  const std::uint32_t at = nearest_[index(p_W)];
  const auto nz = static_cast<std::uint32_t>(size_.z()), ny = static_cast<std::uint32_t>(size_.y());
  return centre({static_cast<int>(at / (ny * nz)), static_cast<int>(at / nz % ny), static_cast<int>(at % nz)});
}

Result<DistanceField> distance_field(const std::vector<Eigen::Vector3d>& occupied, double resolution, double margin) {
  Region region{Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(resolution)};
  if (!occupied.empty()) region = {occupied.front(), occupied.front()};
  for (const auto& p : occupied) {
    region.lower = region.lower.cwiseMin(p);
    region.upper = region.upper.cwiseMax(p);
  }
  const double rim = occupied.empty() ? 0 : margin;
  region.lower = ((region.lower.array() - rim) / resolution).floor() * resolution;
  region.upper = ((region.upper.array() + rim) / resolution).ceil() * resolution;
  return DistanceField::build(occupied, region, resolution);
}

Result<DistanceField> distance_field(const SceneEstimate& estimate, double margin, double height) {
  PRIMO_ASSIGN(const OccupancyMap map, OccupancyMap::from_bytes(estimate.octree));
  const Eigen::Vector3d half(estimate.table.size.x() / 2 + margin, estimate.table.size.y() / 2 + margin, 0);
  Region region{estimate.table.top_centre - half, estimate.table.top_centre + half};
  region.lower.z() -= 0.1;
  region.upper.z() += height;
  // On the map's own grid, so that a voxel of the field is a voxel of the map.
  const double voxel = map.resolution();
  region.lower = (region.lower / voxel).array().floor() * voxel;
  region.upper = (region.upper / voxel).array().ceil() * voxel;
  return DistanceField::build(map.occupied(), region, voxel);
}

}  // namespace primo::scene

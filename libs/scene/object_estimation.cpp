#include "scene/object_estimation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>

namespace primo::scene {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBin = 0.005;  // m, of the histogram of heights
constexpr int kMinTablePoints = 200;
constexpr double kSmallestTable = 0.05, kLargestTable = 5;  // m, as in scenario files
constexpr int kMaxParts = 5, kSplitRounds = 12;

/// The middle of the two neighbouring bins that hold the most points.
double dominant_height(const Points& points, double lowest, double highest) {
  std::vector<int> histogram(static_cast<std::size_t>(std::ceil((highest - lowest) / kBin)) + 2, 0);
  for (const auto& p : points) {
    if (p.z() >= lowest && p.z() < highest) ++histogram[static_cast<std::size_t>((p.z() - lowest) / kBin)];
  }
  std::size_t best = 0;
  for (std::size_t i = 0; i + 1 < histogram.size(); ++i) {
    if (histogram[i] + histogram[i + 1] > histogram[best] + histogram[best + 1]) best = i;
  }
  return lowest + static_cast<double>(best + 1) * kBin;
}

/// Voxel coordinates packed so that neighbours are found by adding packed offsets.
using Key = std::int64_t;
constexpr Key pack(Key x, Key y, Key z) { return (x * (Key{1} << 21) + y) * (Key{1} << 21) + z; }

std::size_t root(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// One part of a split cluster for each of k seeds: the point farthest from all seeds before it becomes the next.
std::vector<int> initial_parts(const Points& points, int parts) {
  Vector2d mean = Vector2d::Zero();
  for (const auto& p : points) mean += p.head<2>();
  mean /= static_cast<double>(points.size());
  std::vector<Vector2d> seeds;
  std::vector<double> distance(points.size(), 1e9);
  for (int k = 0; k < parts; ++k) {
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double d = (points[i].head<2>() - (seeds.empty() ? mean : seeds.back())).norm();
      distance[i] = seeds.empty() ? d : (k == 1 ? d : std::min(distance[i], d));
      if (distance[i] > distance[farthest]) farthest = i;
    }
    seeds.emplace_back(points[farthest].head<2>());
  }
  std::vector<int> part(points.size(), 0);
  for (int round = 0; round < kSplitRounds; ++round) {  // k-means in the plane
    std::vector<Vector3d> sums(static_cast<std::size_t>(parts), Vector3d::Zero());
    for (std::size_t i = 0; i < points.size(); ++i) {
      double best = 1e18;
      for (int k = 0; k < parts; ++k) {
        const double d = (points[i].head<2>() - seeds[static_cast<std::size_t>(k)]).squaredNorm();
        if (d < best) {
          best = d;
          part[i] = k;
        }
      }
      sums[static_cast<std::size_t>(part[i])] += Vector3d(points[i].x(), points[i].y(), 1);
    }
    for (std::size_t k = 0; k < seeds.size(); ++k) {
      if (sums[k].z() > 0) seeds[k] = sums[k].head<2>() / sums[k].z();
    }
  }
  return part;
}

struct Part {
  ShapeFit fit;
  int points = 0;
};

/// m rms over the points of one shape.
struct Tolerance {
  double noise = 0;     ///< what the right shape leaves
  double residual = 0;  ///< beyond it a cluster is more than one shape
};

/// Shapes and their points in turns: fit a shape to each part, then give each point to the shape whose surface is
/// nearest.
std::optional<std::vector<Part>> split(const Points& points, int parts, double table_z, const Tolerance& tolerance,
                                       const PerceptionSettings& settings) {
  std::vector<int> part = initial_parts(points, parts);
  std::vector<Part> result(static_cast<std::size_t>(parts));
  for (int round = 0; round < kSplitRounds; ++round) {
    for (int k = 0; k < parts; ++k) {
      Points own;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (part[i] == k) own.push_back(points[i]);
      }
      if (static_cast<int>(own.size()) < settings.min_points) return std::nullopt;
      const auto fit = fit_shape(own, table_z, settings.min_object_height, tolerance.noise);
      if (!fit) return std::nullopt;
      result[static_cast<std::size_t>(k)] = {*fit, static_cast<int>(own.size())};
    }
    bool changed = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      int nearest = 0;
      double best = 1e18;
      for (int k = 0; k < parts; ++k) {
        const double d = std::abs(result[static_cast<std::size_t>(k)].fit.distance(points[i]));
        if (d < best) {
          best = d;
          nearest = k;
        }
      }
      changed = changed || nearest != part[i];
      part[i] = nearest;
    }
    if (!changed) break;
  }
  const bool good =
      std::all_of(result.begin(), result.end(), [&](const Part& p) { return p.fit.residual <= tolerance.residual; });
  return good ? std::optional(result) : std::nullopt;
}

std::vector<Part> shapes_of(const Points& cluster, double table_z, const Tolerance& tolerance,
                            const PerceptionSettings& settings) {
  const auto one = fit_shape(cluster, table_z, settings.min_object_height, tolerance.noise);
  if (one && one->residual <= tolerance.residual) return {{*one, static_cast<int>(cluster.size())}};
  for (int parts = 2; parts <= kMaxParts; ++parts) {
    if (auto several = split(cluster, parts, table_z, tolerance, settings)) return *several;
  }
  if (one) return {{*one, static_cast<int>(cluster.size())}};
  return {};
}

}  // namespace

Result<TableFit> estimate_table(const Points& points, const PerceptionSettings& settings) {
  double height = dominant_height(points, settings.min_table_height, settings.max_table_height);
  double window = 0.012;
  TableFit fit;
  // No round looks farther than the windows of all before it together.
  constexpr int kRounds = 4;
  constexpr double kMaxWindow = kTableReach / kRounds;
  Points near;
  for (const auto& p : points) {
    if (std::abs(p.z() - height) <= kTableReach) near.push_back(p);
  }
  std::vector<double> xs, ys;
  for (int round = 0; round < kRounds; ++round) {
    const bool last = round + 1 == kRounds;
    double sum = 0, squares = 0;
    fit.points = 0;
    for (const auto& p : near) {
      const double z = p.z() - height;
      if (std::abs(z) > window) continue;
      sum += z;
      squares += z * z;
      ++fit.points;
      if (!last) continue;
      xs.push_back(p.x());
      ys.push_back(p.y());
    }
    const auto count = static_cast<double>(fit.points);
    if (fit.points < kMinTablePoints) {
      return Error{Code::failed, "no table was seen: the level plane with the most points between " +
                                     std::to_string(settings.min_table_height) + " and " +
                                     std::to_string(settings.max_table_height) + " m has " +
                                     std::to_string(fit.points) + " points, needs " + std::to_string(kMinTablePoints)};
    }
    height += sum / count;
    fit.rms = std::sqrt(std::max(0.0, squares / count - sum / count * (sum / count)));
    window = std::clamp(3 * fit.rms, 0.001, kMaxWindow);
  }
  // The outermost row of pixels along an edge is about 1 % of the points: a smaller quantile finds it, not strays.
  const auto edge = [](std::vector<double>& values, double fraction) {
    const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
  };
  const Vector2d lower(edge(xs, 0.002), edge(ys, 0.002)), upper(edge(xs, 0.998), edge(ys, 0.998));
  fit.table.top_centre = {(lower.x() + upper.x()) / 2, (lower.y() + upper.y()) / 2, height};
  fit.table.size = upper - lower;
  if (fit.table.size.minCoeff() < kSmallestTable || fit.table.size.maxCoeff() > kLargestTable) {
    return Error{Code::failed, "no table was seen: the level plane at " + std::to_string(height) + " m is " +
                                   std::to_string(fit.table.size.x()) + " × " + std::to_string(fit.table.size.y()) +
                                   " m, must be between 0.05 and 5 m"};
  }
  return fit;
}

std::vector<Points> clusters(const Points& points, double voxel, int min_points) {
  struct Entry {
    Key key;
    std::size_t point;
  };
  std::vector<Entry> entries;
  entries.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Array3d cell = (points[i].array() / voxel).floor();
    entries.push_back({pack(static_cast<Key>(cell.x()), static_cast<Key>(cell.y()), static_cast<Key>(cell.z())), i});
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.key < b.key || (a.key == b.key && a.point < b.point); });
  std::vector<Key> cells;
  for (const auto& entry : entries) {
    if (cells.empty() || cells.back() != entry.key) cells.push_back(entry.key);
  }
  std::vector<std::size_t> parent(cells.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (int n = 14; n < 27; ++n) {  // the 13 neighbours after the middle; the others are met from the other side
      const Key neighbour = cells[i] + pack(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
      const auto found = std::lower_bound(cells.begin(), cells.end(), neighbour);
      if (found == cells.end() || *found != neighbour) continue;
      const std::size_t a = root(parent, i), b = root(parent, static_cast<std::size_t>(found - cells.begin()));
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<Points> groups(cells.size());
  std::size_t cell = 0;
  for (const auto& entry : entries) {
    while (cells[cell] != entry.key) ++cell;
    groups[root(parent, cell)].push_back(points[entry.point]);
  }
  std::erase_if(groups, [&](const Points& group) { return static_cast<int>(group.size()) < min_points; });
  return groups;
}

std::vector<ObjectEstimate> estimate_objects(const Points& points, const TableFit& table,
                                             const PerceptionSettings& settings) {
  constexpr double kMargin = 0.05, kHighest = 0.8;  // m: objects may stick out over the edge
  const double table_z = table.table.top_centre.z();
  const double above = std::max(settings.above_table, 5 * table.rms);
  // Noise alone must not split a cluster. Rays that meet the table at 45° have 0.7 of their noise along z, at most 0.9
  // elsewhere.
  const double noise = 1.25 * table.rms;
  const Tolerance tolerance{noise, std::max(settings.max_residual, noise)};
  Points on_table;
  for (const auto& p : points) {
    const Vector2d offset = (p - table.table.top_centre).head<2>().cwiseAbs() - table.table.size / 2;
    if (p.z() > table_z + above && p.z() < table_z + kHighest && offset.maxCoeff() < kMargin) on_table.push_back(p);
  }
  std::vector<ObjectEstimate> objects;
  for (const auto& cluster : clusters(on_table, settings.cluster_gap, settings.min_points)) {
    for (const auto& part : shapes_of(cluster, table_z, tolerance, settings)) {
      ObjectEstimate object;
      object.type = part.fit.type;
      object.X_WO = part.fit.X_WO;
      object.shape = part.fit.shape;
      object.residual = part.fit.residual;
      object.points = part.points;
      objects.push_back(std::move(object));
    }
  }
  return objects;
}

}  // namespace primo::scene

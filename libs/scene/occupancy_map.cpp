#include "scene/occupancy_map.h"

#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>

namespace primo::scene {
namespace {

octomap::point3d point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// Where the payload of a .bt stream begins, or npos.
std::size_t payload_begin(std::string_view stream) {
  constexpr std::string_view kData = "\ndata\n";
  const std::size_t at = stream.find(kData);
  return at == std::string_view::npos ? at : at + kData.size();
}

/// Walks the payload: two bytes a node, two bits a child (11: the child has a node of its own). OctoMap reads on past
/// the end of a broken stream, so it only gets whole ones.
Status check_payload(std::string_view payload) {
  constexpr int kMaxDepth = 16;
  std::vector<int> depths;  // of the nodes still to be read, depth first
  if (!payload.empty()) depths.push_back(0);
  std::size_t at = 0;
  while (!depths.empty()) {
    const int depth = depths.back();
    depths.pop_back();
    if (at + 2 > payload.size()) return Error{Code::data, "octree: the stream ends in the middle of the tree"};
    if (depth >= kMaxDepth) return Error{Code::data, "octree: deeper than 16 levels"};
    const auto bits = static_cast<unsigned>(static_cast<unsigned char>(payload[at])) |
                      static_cast<unsigned>(static_cast<unsigned char>(payload[at + 1])) << 8U;
    at += 2;
    for (unsigned child = 0; child < 8; ++child) {
      if ((bits >> (2 * child) & 3U) == 3U) depths.push_back(depth + 1);
    }
  }
  if (at != payload.size()) {
    return Error{Code::data, "octree: " + std::to_string(payload.size() - at) + " bytes follow the end of the tree"};
  }
  return success();
}

/// The number after `key` in the header's lines.
double header_number(std::string_view header, const std::string& key) {
  const std::size_t at = header.find("\n" + key + " ");
  if (at == std::string_view::npos) return -1;
  std::istringstream value{std::string(header.substr(at + key.size() + 2, 40))};
  value.imbue(std::locale::classic());
  double number = -1;
  value >> number;
  return value.fail() || !std::isfinite(number) ? -1 : number;
}

}  // namespace

OccupancyMap::OccupancyMap(std::unique_ptr<octomap::OcTree> tree) : tree_(std::move(tree)) {}
OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;
OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;
OccupancyMap::~OccupancyMap() = default;

OccupancyMap::OccupancyMap(const std::vector<PointCloud>& clouds, const Region& region, double resolution)
    : tree_(std::make_unique<octomap::OcTree>(resolution)) {
  octomap::point3d lower = point(region.lower), upper = point(region.upper);
  tree_->setBBXMin(lower);
  tree_->setBBXMax(upper);
  tree_->useBBXLimit(true);
  for (const auto& cloud : clouds) {
    octomap::Pointcloud scan;
    scan.reserve(cloud.points.size());
    for (const auto& p_C : cloud.points) {
      const Eigen::Vector3d p_W = cloud.X_WC * p_C.cast<double>();
      if (region.contains(p_W)) scan.push_back(point(p_W));
    }
    // Rays to points of one voxel are one ray; inner nodes are brought up to date once, below.
    tree_->insertPointCloud(scan, point(cloud.X_WC.translation()), -1, true, true);
  }
  tree_->updateInnerOccupancy();
  tree_->toMaxLikelihood();
  tree_->prune();
}

Result<OccupancyMap> OccupancyMap::from_bytes(const std::vector<std::uint8_t>& bytes) {
  const std::string stream(bytes.begin(), bytes.end());
  const std::size_t begin = payload_begin(stream);
  if (!stream.starts_with("# Octomap OcTree binary file") || begin == std::string::npos || begin > 4096) {
    return Error{Code::data, "octree: not an OctoMap binary stream, which begins with '# Octomap OcTree binary file'"};
  }
  const std::string_view header = std::string_view(stream).substr(0, begin);
  const double resolution = header_number(header, "res"), size = header_number(header, "size");
  if (header.find("\nid OcTree\n") == std::string_view::npos || !(resolution > 0 && resolution <= 100) ||
      !(size >= 0 && size <= 1e9)) {
    return Error{Code::data, "octree: its header lacks 'id OcTree', a resolution ('res') above 0 or a 'size'"};
  }
  PRIMO_TRY(check_payload(std::string_view(stream).substr(begin)));
  auto tree = std::make_unique<octomap::OcTree>(resolution);
  if (begin == stream.size()) return OccupancyMap(std::move(tree));
  std::istringstream in(stream.substr(begin));
  if (!tree->readBinaryData(in)) return Error{Code::data, "octree: OctoMap could not read the stream"};
  return OccupancyMap(std::move(tree));
}

std::vector<std::uint8_t> OccupancyMap::to_bytes() const {
  // OctoMap's own writer of the header talks on standard error.
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      << "id OcTree\nsize " << tree_->size() << "\nres " << tree_->getResolution() << "\ndata\n";
  tree_->writeBinaryData(out);
  const std::string stream = out.str();
  return {stream.begin(), stream.end()};
}

OccupancyMap::Voxel OccupancyMap::at(const Eigen::Vector3d& p_W) const {
  octomap::OcTreeKey key;
  if (!p_W.allFinite() || !tree_->coordToKeyChecked(point(p_W), key)) return Voxel::unknown;
  const auto* node = tree_->search(key);
  if (!node) return Voxel::unknown;
  return tree_->isNodeOccupied(node) ? Voxel::occupied : Voxel::free;
}

double OccupancyMap::resolution() const { return tree_->getResolution(); }

std::vector<Eigen::Vector3d> OccupancyMap::occupied() const {
  std::vector<Eigen::Vector3d> centres;
  const double voxel = tree_->getResolution();
  for (auto leaf = tree_->begin_leafs(), end = tree_->end_leafs(); leaf != end; ++leaf) {
    if (!tree_->isNodeOccupied(*leaf)) continue;
    const int side = 1 << std::min(tree_->getTreeDepth() - leaf.getDepth(), 8U);
    const Eigen::Vector3d corner =
        Eigen::Vector3d(leaf.getX(), leaf.getY(), leaf.getZ()).array() - (side - 1) * voxel / 2;
    for (int x = 0; x < side; ++x) {
      for (int y = 0; y < side; ++y) {
        for (int z = 0; z < side; ++z) centres.emplace_back(corner + voxel * Eigen::Vector3d(x, y, z));
      }
    }
  }
  return centres;
}

}  // namespace primo::scene

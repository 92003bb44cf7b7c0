#include <array>
#include <bit>
#include <cstring>

#include "wire/check.h"
#include "wire/wire.h"

namespace primo::wire {
namespace {

constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
static_assert(std::endian::native == std::endian::little, "points are copied as they lie in memory");

/// Where x, y and z lie in a point.
Result<std::array<std::size_t, 3>> offsets_of(const sensor_msgs::msg::PointCloud2& message) {
  std::array<std::size_t, 3> offsets{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bool found = false;
    for (const auto& field : message.fields()) {
      if (field.name() != kAxes[axis]) continue;
      if (field.datatype() != kFloat32 || field.count() > 1) {
        return malformed("points.fields", std::string(kAxes[axis]) + " must be one float32");
      }
      if (std::uint64_t{field.offset()} + 4 > message.point_step()) {
        return malformed("points.fields", std::string(kAxes[axis]) + " lies outside of the point");
      }
      offsets[axis] = field.offset();
      found = true;
    }
    if (!found) return malformed("points.fields", std::string("has no ") + kAxes[axis]);
  }
  return offsets;
}

}  // namespace

sensor_msgs::msg::PointCloud2 to_ros(const scene::PointCloud& cloud, const std::string& frame) {
  sensor_msgs::msg::PointCloud2 out;
  out.header().frame_id(frame);
  out.height(1);
  out.width(static_cast<std::uint32_t>(cloud.points.size()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sensor_msgs::msg::PointField field;
    field.name(kAxes[axis]);
    field.offset(static_cast<std::uint32_t>(4 * axis));
    field.datatype(kFloat32);
    field.count(1);
    out.fields().push_back(std::move(field));
  }
  out.is_bigendian(false);
  out.point_step(12);
  out.row_step(static_cast<std::uint32_t>(12 * cloud.points.size()));
  out.data().resize(12 * cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) std::memcpy(&out.data()[12 * i], cloud.points[i].data(), 12);
  out.is_dense(true);
  return out;
}

Result<scene::PointCloud> from_ros(const sensor_msgs::msg::PointCloud2& message) {
  if (message.is_bigendian()) return malformed("points", "are big-endian, expected little-endian");
  PRIMO_ASSIGN(const auto offsets, offsets_of(message));
  const std::uint64_t rows = message.height(), columns = message.width();
  const std::uint64_t row_step = message.row_step(), point_step = message.point_step();
  if (columns > kMaxNumbers || rows > kMaxNumbers || rows * columns > kMaxNumbers || columns * point_step > row_step ||
      rows * row_step > message.data().size()) {
    return malformed("points.data",
                     "has " + std::to_string(message.data().size()) + " bytes, less than width, height and steps say");
  }
  scene::PointCloud out;
  out.points.reserve(rows * columns);
  for (std::uint64_t row = 0; row < rows; ++row) {
    for (std::uint64_t column = 0; column < columns; ++column) {
      const std::uint8_t* point = message.data().data() + row * row_step + column * point_step;
      Eigen::Vector3f p;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::memcpy(&p[static_cast<Eigen::Index>(axis)], point + offsets[axis], sizeof(float));
      }
      if (p.allFinite()) out.points.push_back(p);
    }
  }
  return out;
}

}  // namespace primo::wire

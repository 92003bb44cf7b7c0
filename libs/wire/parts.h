// Adapters of the small types that several messages share.
#pragma once

#include <primo_common.h>
#include <primo_scene.h>

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "core/statistics.h"
#include "robot/shape.h"
#include "scene/scenario.h"
#include "symbols/literal.h"

namespace primo::wire {

namespace msg = primo_msgs::msg;

geometry_msgs::msg::Vector3 to_vector(const Eigen::Vector3d& v);
geometry_msgs::msg::Point to_point(const Eigen::Vector3d& p);
Eigen::Vector3d from_vector(const geometry_msgs::msg::Vector3& v);
Eigen::Vector3d from_point(const geometry_msgs::msg::Point& p);

msg::RigidPose to_wire(const Pose& X_AB);
/// Bit for bit what was sent. Error: not finite, or not a rotation to within 1e-6.
Result<Pose> from_wire(const std::string& field, const msg::RigidPose& pose);

msg::Shape to_wire(const Shape& shape);
/// Error also for sizes outside 0 … 10 m.
Result<Shape> from_wire(const std::string& field, const msg::Shape& shape);

msg::Matrix to_wire(const Eigen::MatrixXd& matrix);
/// Error: rows × cols is not the number of entries, or an entry is not finite.
Result<Eigen::MatrixXd> from_wire(const std::string& field, const msg::Matrix& matrix);

std::vector<msg::Matrix> to_wire(const std::vector<Eigen::MatrixXd>& matrices);
Result<std::vector<Eigen::MatrixXd>> from_wire(const std::string& field, const std::vector<msg::Matrix>& matrices);

std::vector<msg::Literal> to_wire(const std::vector<symbols::Literal>& literals);
std::vector<msg::Literal> to_wire(const symbols::State& state);
Result<symbols::Literal> from_wire(const std::string& field, const msg::Literal& literal);
Result<std::vector<symbols::Literal>> from_wire(const std::string& field, const std::vector<msg::Literal>& literals);
Result<symbols::State> state_from_wire(const std::string& field, const std::vector<msg::Literal>& literals);

msg::SceneTable to_wire(const scene::Table& table);
Result<scene::Table> from_wire(const std::string& field, const msg::SceneTable& table);

msg::Rate to_wire(const Rate& rate);
/// Error: negative, or more successes than trials.
Result<Rate> from_wire(const std::string& field, const msg::Rate& rate);

}  // namespace primo::wire

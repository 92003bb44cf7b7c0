#include "wire/parts.h"

#include "wire/check.h"
#include "wire/wire.h"

namespace primo::wire {

geometry_msgs::msg::Vector3 to_vector(const Eigen::Vector3d& v) {
  geometry_msgs::msg::Vector3 out;
  out.x(v.x());
  out.y(v.y());
  out.z(v.z());
  return out;
}

geometry_msgs::msg::Point to_point(const Eigen::Vector3d& p) {
  geometry_msgs::msg::Point out;
  out.x(p.x());
  out.y(p.y());
  out.z(p.z());
  return out;
}

Eigen::Vector3d from_vector(const geometry_msgs::msg::Vector3& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d from_point(const geometry_msgs::msg::Point& p) { return {p.x(), p.y(), p.z()}; }

msg::RigidPose to_wire(const Pose& X_AB) {
  msg::RigidPose out;
  out.position(to_point(X_AB.translation()));
  for (int i = 0; i < 9; ++i) out.rotation()[static_cast<std::size_t>(i)] = X_AB.linear()(i / 3, i % 3);
  return out;
}

Result<Pose> from_wire(const std::string& field, const msg::RigidPose& pose) {
  Pose X_AB = Pose::Identity();
  X_AB.translation() = from_point(pose.position());
  for (int i = 0; i < 9; ++i) X_AB.linear()(i / 3, i % 3) = pose.rotation()[static_cast<std::size_t>(i)];
  if (!X_AB.matrix().allFinite()) return malformed(field, "is not finite");
  const Eigen::Matrix3d R = X_AB.linear();
  // Bounded first, so that the product can't overflow.
  if (R.cwiseAbs().maxCoeff() > 2 || (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-6 ||
      R.determinant() < 0) {
    return malformed(field, "has a matrix that is not a rotation");
  }
  return X_AB;
}

msg::Shape to_wire(const Shape& shape) {
  msg::Shape out;
  out.type(static_cast<std::uint8_t>(shape.type));
  out.size(to_vector(shape.size));
  return out;
}

Result<Shape> from_wire(const std::string& field, const msg::Shape& shape) {
  Shape out;
  PRIMO_ASSIGN(out.type, enum_from<ShapeType>(field + ".type", shape.type()));
  out.size = from_vector(shape.size());
  if (!out.size.allFinite() || out.size.minCoeff() < 0 || out.size.maxCoeff() > 10) {
    return malformed(field + ".size", "must be 0 to 10 m");
  }
  return out;
}

msg::Matrix to_wire(const Eigen::MatrixXd& matrix) {
  msg::Matrix out;
  out.rows(static_cast<std::uint32_t>(matrix.rows()));
  out.cols(static_cast<std::uint32_t>(matrix.cols()));
  out.data().resize(static_cast<std::size_t>(matrix.size()));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out.data().data(), matrix.rows(),
                                                                                     matrix.cols()) = matrix;
  return out;
}

Result<Eigen::MatrixXd> from_wire(const std::string& field, const msg::Matrix& matrix) {
  const std::uint64_t size = std::uint64_t{matrix.rows()} * matrix.cols();
  if (size != matrix.data().size()) {
    return malformed(field, "is " + std::to_string(matrix.rows()) + " × " + std::to_string(matrix.cols()) +
                                " but has " + std::to_string(matrix.data().size()) + " entries");
  }
  if (size == 0 && (matrix.rows() > kMaxItems || matrix.cols() > kMaxItems)) return malformed(field, "is too large");
  PRIMO_TRY(check_finite(field, matrix.data()));
  return Eigen::MatrixXd(Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      matrix.data().data(), matrix.rows(), matrix.cols()));
}

std::vector<msg::Matrix> to_wire(const std::vector<Eigen::MatrixXd>& matrices) {
  std::vector<msg::Matrix> out;
  out.reserve(matrices.size());
  for (const Eigen::MatrixXd& matrix : matrices) out.push_back(to_wire(matrix));
  return out;
}

Result<std::vector<Eigen::MatrixXd>> from_wire(const std::string& field, const std::vector<msg::Matrix>& matrices) {
  PRIMO_TRY(check_count(field, matrices.size()));
  std::vector<Eigen::MatrixXd> out;
  out.reserve(matrices.size());
  for (const msg::Matrix& matrix : matrices) {
    PRIMO_ASSIGN(Eigen::MatrixXd converted, from_wire(field, matrix));
    out.push_back(std::move(converted));
  }
  return out;
}

msg::Literal to_wire(const symbols::Literal& literal) {
  msg::Literal out;
  out.predicate(literal.predicate);
  out.arguments(literal.arguments);
  out.negated(literal.negated);
  out.relation(static_cast<std::uint8_t>(literal.relation));
  out.value(literal.value);
  return out;
}

Result<symbols::Literal> from_wire(const std::string& field, const msg::Literal& literal) {
  PRIMO_TRY(check_text(field, literal.predicate()));
  PRIMO_TRY(check_count(field, literal.arguments().size(), 8));
  PRIMO_TRY(check_texts(field, literal.arguments()));
  if (literal.predicate().empty()) return malformed(field, "is a literal without a predicate");
  if (literal.relation() > 3) {
    return malformed(field, "has relation " + std::to_string(literal.relation()) + ", expected less than 4");
  }
  const auto relation = static_cast<symbols::Relation>(literal.relation());
  return symbols::Literal{literal.predicate(), literal.arguments(), literal.negated(), relation, literal.value()};
}

Result<symbols::Literal> from_wire(const msg::Literal& message) { return from_wire("literal", message); }

std::vector<msg::Literal> to_wire(const std::vector<symbols::Literal>& literals) {
  std::vector<msg::Literal> out;
  for (const symbols::Literal& literal : literals) out.push_back(to_wire(literal));
  return out;
}

std::vector<msg::Literal> to_wire(const symbols::State& state) {
  std::vector<msg::Literal> out;
  for (const symbols::Literal& literal : state) out.push_back(to_wire(literal));
  return out;
}

Result<std::vector<symbols::Literal>> from_wire(const std::string& field, const std::vector<msg::Literal>& literals) {
  PRIMO_TRY(check_count(field, literals.size()));
  std::vector<symbols::Literal> out;
  for (const msg::Literal& literal : literals) {
    PRIMO_ASSIGN(symbols::Literal converted, from_wire(field, literal));
    out.push_back(std::move(converted));
  }
  return out;
}

Result<symbols::State> state_from_wire(const std::string& field, const std::vector<msg::Literal>& literals) {
  PRIMO_ASSIGN(const auto all, from_wire(field, literals));
  symbols::State state;
  for (const symbols::Literal& literal : all) {
    if (literal.negated) return malformed(field, "holds a negated literal; a state lists what is true");
    state.insert(literal);
  }
  return state;
}

msg::SceneTable to_wire(const scene::Table& table) {
  msg::SceneTable out;
  out.name(table.name);
  out.top_centre(to_point(table.top_centre));
  out.size_x(table.size.x());
  out.size_y(table.size.y());
  out.thickness(table.thickness);
  return out;
}

Result<scene::Table> from_wire(const std::string& field, const msg::SceneTable& table) {
  scene::Table out;
  out.name = table.name();
  out.top_centre = from_point(table.top_centre());
  out.size = {table.size_x(), table.size_y()};
  out.thickness = table.thickness();
  PRIMO_TRY(check_fields(field, out));
  return out;
}

msg::Rate to_wire(const Rate& rate) {
  msg::Rate out;
  out.successes(rate.successes);
  out.trials(rate.trials);
  return out;
}

Result<Rate> from_wire(const std::string& field, const msg::Rate& rate) {
  if (rate.successes() < 0 || rate.successes() > rate.trials()) {
    return malformed(field, "has " + std::to_string(rate.successes()) + " successes in " +
                                std::to_string(rate.trials()) + " trials");
  }
  return Rate{rate.successes(), rate.trials()};
}

}  // namespace primo::wire

#include "optim/state.h"

#include <algorithm>

namespace primo::optim {
namespace {
Error wrong(const std::string& name, const std::string& what) {
  return {Code::data, "the optimizer's state: '" + name + "' " + what};
}
}  // namespace

Result<std::vector<double>> StateReader::numbers(const std::string& name) const {
  const auto at = state_.find(name);
  if (at == state_.end()) return wrong(name, "is missing");
  if (!std::all_of(at->second.begin(), at->second.end(), [](double v) { return std::isfinite(v); })) {
    return wrong(name, "holds a number that is not finite");
  }
  return at->second;
}

Result<std::vector<double>> StateReader::numbers(const std::string& name, std::size_t size) const {
  PRIMO_ASSIGN(auto values, numbers(name));
  if (values.size() == size) return values;
  return wrong(name, "has " + std::to_string(values.size()) + " numbers, must have " + std::to_string(size));
}

Result<double> StateReader::number(const std::string& name, double low, double high) const {
  PRIMO_ASSIGN(const auto values, numbers(name, 1));
  if (values[0] >= low && values[0] <= high) return values[0];
  return wrong(name, "is " + config::detail::format(values[0]) + ", must be in " + config::detail::format(low) + " … " +
                         config::detail::format(high));
}

Result<int> StateReader::whole(const std::string& name, int low, int high) const {
  PRIMO_ASSIGN(const double value, number(name, low, high));
  if (value == std::floor(value)) return static_cast<int>(value);
  return wrong(name, "is " + config::detail::format(value) + ", must be a whole number");
}

Result<Eigen::VectorXd> StateReader::vector(const std::string& name, int size) const {
  PRIMO_ASSIGN(const auto values, numbers(name, static_cast<std::size_t>(size)));
  return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), size));
}

Result<Eigen::MatrixXd> StateReader::square(const std::string& name, int size) const {
  PRIMO_ASSIGN(const auto values, numbers(name, static_cast<std::size_t>(size) * static_cast<std::size_t>(size)));
  return Eigen::MatrixXd(Eigen::Map<const Eigen::MatrixXd>(values.data(), size, size));
}

}  // namespace primo::optim

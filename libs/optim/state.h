// Reading a State back: what is missing, has another size or cannot be is an Error (data).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "optim/optimizer.h"

namespace primo::optim {

class StateReader {
 public:
  explicit StateReader(const State& state) : state_(state) {}

  /// The numbers of this name; all of them finite.
  Result<std::vector<double>> numbers(const std::string& name) const;
  /// The same, exactly `size` of them.
  Result<std::vector<double>> numbers(const std::string& name, std::size_t size) const;
  Result<double> number(const std::string& name, double low, double high) const;
  /// A whole number in low … high.
  Result<int> whole(const std::string& name, int low, int high) const;
  Result<Eigen::VectorXd> vector(const std::string& name, int size) const;
  Result<Eigen::MatrixXd> square(const std::string& name, int size) const;

 private:
  const State& state_;
};

inline std::vector<double> flat(const Eigen::MatrixXd& m) { return {m.data(), m.data() + m.size()}; }

}  // namespace primo::optim

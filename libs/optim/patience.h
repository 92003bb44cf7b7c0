// When a descent on a noisy fitness has come to nothing. Where every generation is judged with other random numbers no
// two costs are equal, so that on a plateau the criteria of a noise-free descent (descent.h) speak too late for a
// budget of a hundred generations.
#pragma once

#include <limits>
#include <vector>

#include "optim/optimizer.h"
#include "optim/state.h"

namespace primo::optim {

class Patience {
 public:
  /// `generations`: how many may pass without a rise; 0: any number. `rise`: of the fitness, what counts as one.
  Patience(int generations, double rise) : generations_(generations), rise_(rise) {}

  /// The costs of a generation. It has risen when its best or its mean is better than at the last rise by more than
  /// `rise`.
  void add(const std::vector<double>& costs);
  bool over() const { return generations_ > 0 && since_ >= generations_; }
  /// A new descent begins.
  void reset() { *this = Patience(generations_, rise_); }

  void save(State& state) const;
  Status load(const StateReader& state);

 private:
  int generations_;
  double rise_;
  int since_ = 0;  ///< generations since the last rise
  double best_ = std::numeric_limits<double>::max(), mean_ = std::numeric_limits<double>::max();  ///< costs at it
};

}  // namespace primo::optim

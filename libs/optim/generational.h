// What the optimizers here share: they ask a generation, wait until all of it has been told, and go on from there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "optim/optimizer.h"
#include "optim/state.h"

namespace primo::optim {

class Generational : public Optimizer {
 public:
  std::vector<Candidate> ask() const final;
  Status tell(int generation, int index, double fitness) final;
  bool done() const final { return !stop_reason().empty(); }
  std::string stop_reason() const final;
  int evaluations() const final { return before_ + told_; }
  std::vector<double> recommendation() const override { return best(); }
  std::vector<double> best() const final { return best_.empty() ? first_ : best_; }
  double best_fitness() const final { return best_fitness_; }
  const OptimizerSettings& settings() const final { return settings_; }
  const Bounds& bounds() const final { return bounds_; }
  State state() const final;
  Status restore(const State& state) final;

 protected:
  Generational(OptimizerSettings settings, Bounds bounds)
      : settings_(std::move(settings)), bounds_(std::move(bounds)) {}
  /// @pre Called at the end of every derived constructor.
  void begin();

  /// The candidates of the present generation, in the box.
  virtual std::vector<std::vector<double>> samples() const = 0;
  /// Learns from a generation of which all is told; number() is still its own.
  virtual void advance(const std::vector<double>& fitness) = 0;
  /// The size of the next generation. One that does not fit into the budget ends the search.
  virtual int wanted() const = 0;
  /// Why the algorithm itself ends, or nothing.
  virtual std::string stopped() const { return {}; }
  virtual void save(State& state) const = 0;
  virtual Status load(const StateReader& state) = 0;

  int dimension() const { return static_cast<int>(bounds_.lower.size()); }
  int number() const { return number_; }                             ///< of the present generation
  int size() const { return static_cast<int>(fitness_.size()); }     ///< of the present generation
  int before() const { return before_; }                             ///< evaluations of complete generations
  int remaining() const { return settings_.evaluations - before_; }  ///< evaluations, with the present generation
  /// From the unit box to the box; what is outside goes to its boundary.
  std::vector<double> in_box(const std::vector<double>& u) const;

 private:
  OptimizerSettings settings_;
  Bounds bounds_;
  int number_ = 0, before_ = 0, told_ = 0;
  std::vector<std::optional<double>> fitness_;  // of the present generation
  std::vector<double> first_;                   // the very first candidate: what is best before anything is known
  std::vector<double> best_;
  double best_fitness_;
};

}  // namespace primo::optim

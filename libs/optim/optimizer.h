// Black-box maximisers behind ask/tell. The state is a value: ask is a pure function of it, tell takes results in any
// order.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/result.h"

namespace primo::optim {

struct OptimizerSettings {
  std::string name = "cma";  ///< a key of optimizers()
  int evaluations = 2000;    ///< budget
  int population = 0;        ///< λ; 0: the algorithm's default
  double sigma = 0.3;        ///< initial step as a fraction of the box's width
  std::uint64_t seed = 1;
  int restart = 0;  ///< index of the restart: another random start from the same seed
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "the algorithm"});
    v("evaluations", evaluations, {.help = "budget", .min = 1, .max = 1e9});
    v("population", population,
      {.help = "candidates a generation; 0: the algorithm's default", .min = 0, .max = 10000});
    v("sigma", sigma, {.help = "initial step, fraction of the box's width", .min = 1e-6, .max = 2});
    v("seed", seed, {});
    v("restart", restart, {.help = "index of the restart", .min = 0, .max = 1e6});
  }
};

struct Bounds {
  std::vector<double> lower, upper;
};

struct Candidate {
  int generation = 0;
  int index = 0;          ///< within the generation
  std::vector<double> x;  ///< within bounds
};

class Optimizer {
 public:
  virtual ~Optimizer() = default;
  /// The present generation, all of it. The same until every member has been told.
  virtual std::vector<Candidate> ask() const = 0;
  /// The fitness (greater is better) of a candidate of the present generation. Doubled and late results are ignored.
  /// Errors: NaN or infinite fitness, an index out of range.
  virtual Status tell(int generation, int index, double fitness) = 0;
  virtual bool done() const = 0;
  virtual std::string stop_reason() const = 0;  ///< empty until done
  virtual int evaluations() const = 0;          ///< told
  virtual std::vector<double> recommendation()
      const = 0;  ///< what to use: the distribution's mean where there is one, else the best
  virtual std::vector<double> best() const = 0;  ///< the best sample
  virtual double best_fitness() const = 0;
  virtual double sigma() const { return 0; }  ///< overall step as a fraction of the box's width; 0 where there is none
};

/// Errors: unknown name (lists the known), bounds of different sizes or in the wrong order, a budget below one
/// generation.
Result<std::unique_ptr<Optimizer>> make_optimizer(const OptimizerSettings& settings, const Bounds& bounds);
std::vector<std::string> optimizer_names();

}  // namespace primo::optim

// Black-box maximisers behind ask/tell. The state is a value: ask is a pure function of it, tell takes results in any
// order.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/result.h"

namespace primo::optim {

/// The keys that an optimizer and a study's search have in common, but for what depends on the fitness.
template <class V, class Settings>
void visit_search(V&& v, Settings& settings) {
  v("population", settings.population,
    {.help = "candidates a generation; 0: the algorithm's default", .min = 0, .max = 10000});
  v("sigma", settings.sigma, {.help = "initial step, fraction of the box's width", .min = 1e-6, .max = 2});
  v("on_stagnation", settings.on_stagnation,
    {.help = "of cma: begin elsewhere with twice the population (ipop), with large and small ones in turn (bipop), "
             "with the same (again), or end (stop)",
     .choices = {"ipop", "bipop", "again", "stop"}});
  v("patience", settings.patience,
    {.help = "of cma: generations without a rise of the best or the mean fitness after which a descent has stagnated; "
             "0: by the criteria of a fitness without noise alone",
     .min = 0,
     .max = 1e6});
}

struct OptimizerSettings {
  std::string name = "cma";  ///< a key of optimizers()
  int evaluations = 2000;    ///< budget
  int population = 0;        ///< λ; 0: the algorithm's default
  double sigma = 0.3;        ///< initial step as a fraction of the box's width
  std::uint64_t seed = 1;
  int restart = 0;                     ///< index of the restart: another random start from the same seed
  std::string on_stagnation = "ipop";  ///< what cma does then; see restarts.h
  int patience = 0;                    ///< generations; see patience.h
  double least_rise = 0.01;            ///< of the fitness; see patience.h
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "the algorithm"});
    v("evaluations", evaluations, {.help = "budget", .min = 1, .max = 1e9});
    v("seed", seed, {});
    v("restart", restart, {.help = "index of the restart", .min = 0, .max = 1e6});
    visit_search(v, *this);
    v("least_rise", least_rise, {.help = "what counts as a rise", .min = 0, .max = 1e6});
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

/// All that an optimizer knows beside its settings and bounds, by name. Numbers are finite; counts are whole.
using State = std::map<std::string, std::vector<double>>;

class Optimizer {
 public:
  virtual ~Optimizer() = default;
  /// The present generation, all of it. The same until every member has been told.
  virtual std::vector<Candidate> ask() const = 0;
  /// The fitness (greater is better) of a candidate of the present generation. Doubled and late results are ignored.
  /// Errors: NaN or infinite fitness, an index out of range, a generation that was not asked.
  virtual Status tell(int generation, int index, double fitness) = 0;
  virtual bool done() const = 0;
  virtual std::string stop_reason() const = 0;  ///< empty until done
  virtual int evaluations() const = 0;          ///< told
  /// What to use: the distribution's mean where there is one, else the best sample.
  virtual std::vector<double> recommendation() const = 0;
  virtual std::vector<double> best() const = 0;   ///< the best sample of complete generations
  virtual double best_fitness() const = 0;        ///< −∞ before the first
  virtual double sigma() const { return 0; }      ///< overall step, fraction of the box's width; 0 where there is none
  virtual double condition() const { return 1; }  ///< of the distribution's covariance
  virtual int restarts() const { return 0; }      ///< after stagnation, so far
  /// Whether nothing but the best sample so far matters to it, so that of any other the rank is not needed.
  virtual bool keeps_only_best() const { return false; }
  virtual bool stagnated() const { return false; }  ///< whether that is why it is done
  virtual const OptimizerSettings& settings() const = 0;
  virtual const Bounds& bounds() const = 0;

  virtual State state() const = 0;
  /// Goes on from this state, bit for bit. @pre same settings (but the budget) and bounds as the optimizer that gave
  /// it. Error (data): it cannot be a state of this optimizer; then this one must not be used any more.
  virtual Status restore(const State& state) = 0;
};

/// Errors: unknown name (lists the known), bounds of different sizes or in the wrong order, a budget below one
/// generation.
Result<std::unique_ptr<Optimizer>> make_optimizer(const OptimizerSettings& settings, const Bounds& bounds);
std::vector<std::string> optimizer_names();

}  // namespace primo::optim

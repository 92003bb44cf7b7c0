// The switches of an optimization: what its fitness is, how its noise is treated, when it ends. Defaults are the
// measured ones; docs/optimizers.md has the measurements.
#pragma once

#include <vector>

#include "config/config.h"
#include "study/fitness.h"

namespace primo::study {

/// What may become P*.
enum class Recommendation {
  validated,  ///< the distribution's mean and the best sample are tried with fresh seeds, the better one wins
  mean,       ///< the distribution's mean alone, where there is one
  best,       ///< the best sample alone
};
}  // namespace primo::study

template <>
struct primo::config::EnumNames<primo::study::Signal> {
  static constexpr std::array<std::string_view, 3> names = {"mixed", "graded", "binary"};
};
template <>
struct primo::config::EnumNames<primo::study::Recommendation> {
  static constexpr std::array<std::string_view, 3> names = {"validated", "mean", "best"};
};

namespace primo::study {

/// Ends an algorithm before its budget is spent: when in each of the last `generations` generations some candidate
/// succeeded in all scenarios, the best γ rose by less than `tolerance` over them, and the recommendation itself
/// succeeds in all scenarios. Where each generation draws scenarios of its own, success everywhere is luck of the draw
/// and the best γ that of the easiest one: there it ends when the mean γ of all candidates, over the last `generations`
/// generations, is less than `tolerance` above that over as many before them.
struct EarlyStop {
  int generations = 0;
  double tolerance = 0.01;
  template <class V>
  void visit(V&& v) {
    v("generations", generations,
      {.help = "generations of full success without progress after which to stop; 0: never", .min = 0, .max = 1e6});
    v("tolerance", tolerance, {.help = "rise of the best γ that counts as progress", .min = 0, .max = 10});
  }
};

/// Candidates race over the scenarios: after so many scenarios each the worse ones are dropped, those equal to the last
/// one kept are kept too. A dropped candidate ranks below all that went further. The rounds are barriers, so the order
/// of answers does not matter.
struct Racing {
  std::vector<int> rounds;
  double keep = 0.5;
  template <class V>
  void visit(V&& v) {
    v("rounds", rounds,
      {.help = "scenarios after which the worse candidates are dropped, e.g. [2, 4]; empty: no racing",
       .min = 1,
       .max = 100000});
    v("keep", keep, {.help = "share of the candidates that goes on from a round", .min = 0.05, .max = 1});
  }
};

/// What OptimizeGoal::settings holds as YAML.
struct OptimizationSettings {
  Signal signal = Signal::mixed;
  FitnessSettings fitness;
  bool common_random_numbers = true;
  bool reevaluate_incumbent = false;
  Recommendation recommendation = Recommendation::validated;
  Racing racing;
  bool give_up = true;
  EarlyStop early_stop;
  int validation = 3;
  double sensitivity = 0.05;
  double log_rho_min = -3, log_rho_max = 9;
  template <class V>
  void visit(V&& v) {
    v("signal", signal, {.help = "what γ is the mean of"});
    v("fitness", fitness, {});
    v("common_random_numbers", common_random_numbers,
      {.help = "one jiggle seed a scenario for all candidates of a generation; else each candidate has its own"});
    v("reevaluate_incumbent", reevaluate_incumbent,
      {.help = "the best sample is evaluated anew in each generation, on the budget, and its mean γ counts"});
    v("recommendation", recommendation, {.help = "what may become P*"});
    v("racing", racing, {});
    v("give_up", give_up,
      {.help = "where only the best sample counts (monte_carlo, sobol), one that can no longer become it is not rolled "
               "out in the remaining scenarios; the result is the same"});
    v("early_stop", early_stop, {});
    v("validation", validation, {.help = "fresh jiggle seeds a scenario for the final choice", .min = 1, .max = 1000});
    v("sensitivity", sensitivity,
      {.help =
           "each open entry of P* is moved down and up by this fraction of its range, to see what it matters; 0: not",
       .min = 0,
       .max = 0.5});
    v("log_rho_min", log_rho_min, {.help = "lower bound of log10 ρ", .min = -12, .max = 12});
    v("log_rho_max", log_rho_max, {.help = "upper bound of log10 ρ", .min = -12, .max = 12});
  }
  Status validate() const;
};

}  // namespace primo::study

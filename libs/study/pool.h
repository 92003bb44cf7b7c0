// The robust protocol's many training scenarios: displaced copies of the few, from which each generation draws.
// The paper (VI) names more and resampled scenarios as the remedy for its six being overfitted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "config/config.h"
#include "core/result.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::study {

/// How a primitive is trained.
enum class Protocol {
  paper,   ///< on the fixed training scenarios, as published
  robust,  ///< on displaced copies of them, drawn anew for each generation
};

/// The displaced copies of the training scenarios. Read under the robust protocol only.
struct PoolSettings {
  int scenarios = 240;
  double displacement = 0.05;
  std::uint64_t seed = 3001;
  int drawn = 0;
  int validation = 60;
  std::uint64_t validation_seed = 4001;
  template <class V>
  void visit(V&& v) {
    v("scenarios", scenarios,
      {.help = "displaced copies of the training scenarios to draw from", .min = 1, .max = 10000});
    v("displacement", displacement,
      {.help =
           "greatest displacement of a copy, on each axis in the plane, of every object; the copies' own are spread "
           "evenly from 0 to it",
       .unit = "m",
       .min = 0,
       .max = 0.5});
    v("seed", seed, {.help = "of the copies"});
    v("drawn", drawn,
      {.help = "copies that a generation is tried on; 0: as many as there are training scenarios",
       .min = 0,
       .max = 10000});
    v("validation", validation,
      {.help = "further copies, which no generation sees, for the final choice", .min = 1, .max = 10000});
    v("validation_seed", validation_seed, {.help = "of these"});
  }
};

/// `count` copies of the training scenarios, in order of their original, then of their displacement: copy j of n of one
/// original is displaced by at most (j + u)/n of `displacement` (m), u uniform in [0, 1). Names end in
/// "_<label>_<index>". No object lies in the robot at its start. Errors: those of scene::displace().
Result<std::vector<scene::Scenario>> draw_pool(const robot::Robot& robot, const std::vector<scene::Scenario>& training,
                                               int count, double displacement, std::uint64_t seed,
                                               const std::string& label);

/// Which `drawn` of the first `pool` scenarios a generation is tried on, ascending: one from each of `drawn` equal
/// parts of the pool, so that every draw spans the originals and the displacements. The same for all candidates of the
/// generation. All of them where drawn is 0 or not less than pool.
std::vector<std::size_t> draw_from_pool(std::size_t pool, std::size_t drawn, std::uint64_t seed, int round,
                                        int generation);

/// Error (config) naming the first two keys that have the same seed. Scenarios of one seed are the same numbers
/// wherever they are drawn, so training, choice, experience and tests need seeds of their own.
Status check_distinct_seeds(const std::vector<std::pair<std::string, std::uint64_t>>& seeds);

}  // namespace primo::study

template <>
struct primo::config::EnumNames<primo::study::Protocol> {
  static constexpr std::array<std::string_view, 2> names = {"paper", "robust"};
};

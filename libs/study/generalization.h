// How P and P* do in scenarios that nothing was chosen by (paper, V.C; Figures 3 and 6, Tables I and II).
#pragma once

#include <cstdint>
#include <vector>

#include "robot/robot.h"
#include "study/result.h"
#include "study/study.h"
#include "study/trials.h"

namespace primo::study {

/// Displaced copies of base scenarios, the bases in turn.
struct Drawn {
  std::vector<scene::Scenario> scenarios;
  int rejected_touching = 0, rejected_falling = 0, rejected_in_robot = 0;  ///< draws refused for them (scene::displace)
};

/// Scenarios number `first` … first + count − 1 of the stream `seed`; each is the same whichever others are drawn.
/// `label` goes into their names. d in m. Draws with an object in the robot at its start are refused, too. Error: no
/// valid draw.
Result<Drawn> draw_displaced(const robot::Robot& robot, const std::vector<scene::Scenario>& bases, double d,
                             std::uint64_t seed, std::size_t first, std::size_t count, const std::string& label);

/// Scenario `index` of a level (by its place in the settings).
Result<scene::Scenario> held_out_scenario(const robot::Robot& robot, const Part& part, std::size_t level,
                                          std::size_t index);

/// The rollout of a primitive there, with the seed that generalize() uses.
Rollout held_out_rollout(const Part& part, std::size_t level, std::size_t index, scene::Scenario scenario,
                         scene::SceneEstimate estimate, const motion::Primitive& primitive, physics::Mode mode);

/// All levels of the part's settings. `id` begins the experiences' ids.
Result<std::vector<Level>> generalize(const robot::Robot& robot, const Part& part, const std::string& id,
                                      const motion::Primitive& before, const motion::Primitive& after, Trials& trials);

}  // namespace primo::study

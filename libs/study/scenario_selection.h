// Training scenarios by a seeded procedure (paper, V.A.a): those that are difficult for the hand-tuned primitive
// although one other primitive succeeds in all of them, so that a common ρ exists.
#pragma once

#include <functional>
#include <vector>

#include "core/statistics.h"
#include "motion/primitive.h"
#include "scene/generator.h"
#include "study/backend.h"

namespace primo::study {

struct SelectionSettings {
  std::uint64_t seed = 1;         ///< of the displacements and judgements
  int count = 6;                  ///< scenarios to choose
  int pool = 200;                 ///< random scenes to try at most
  int displaced = 8;              ///< displaced copies in which both primitives are tried, beside the scene itself
  double displacement = 0.01;     ///< m
  double difficult_below = 0.35;  ///< the hand-tuned primitive's strict success rate is at most this
  double feasible_from = 0.85;    ///< the reference primitive's is at least this, and it succeeds in the scene itself
  physics::JudgeSettings judge;
};

struct SelectedScenario {
  scene::Scenario scenario;
  int index = 0;    ///< of the random scene
  Rate hand_tuned;  ///< strict success in the scene and its displaced copies
  Rate reference;
  bool chosen = false;
};

/// Random scene `index`, with its robot_start.
using SceneSource = std::function<Result<scene::Scenario>(std::uint64_t index)>;

/// Tries the random scenes of the source in order and takes the first `count` that are difficult and feasible. Returns
/// all that were tried, in order. In no displaced copy does an object lie in the robot. Error (failed): the pool holds
/// too few, with the counts.
Result<std::vector<SelectedScenario>> select_difficult(
    const SelectionSettings& settings, const robot::Robot& robot, const SceneSource& scene,
    const motion::Primitive& hand_tuned, const motion::Primitive& reference, Workers& workers,
    const std::function<void(const SelectedScenario&)>& on_tried = {});

}  // namespace primo::study

// How a held grasp fares in more jiggles than the one that decides: a graded signal beside the verdict.
#pragma once

#include <vector>

#include "physics/grasp_trial.h"

namespace primo::physics {

/// One row for each of settings.survival_amplitudes: settings.survival_seeds trials with jiggles that many times as
/// large. The jiggles are keyed by `seed`, the row and the trial, and none of them is the verdict's own. Arguments as
/// of run_trial().
std::vector<Survival> survival_table(const robot::Robot& robot, HandWorkspace& workspace, const Eigen::VectorXd& q,
                                     const Pose& X_WP, const Pose& X_WO, const JudgeSettings& settings,
                                     std::uint64_t seed);

}  // namespace primo::physics

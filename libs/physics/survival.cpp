#include "physics/survival.h"

namespace primo::physics {

std::vector<Survival> survival_table(const robot::Robot& robot, HandWorkspace& workspace, const Eigen::VectorXd& q,
                                     const Pose& X_WP, const Pose& X_WO, const JudgeSettings& settings,
                                     std::uint64_t seed) {
  std::vector<Survival> rows;
  if (settings.survival_seeds == 0) return rows;
  for (const double amplitude : settings.survival_amplitudes) {
    JudgeSettings scaled = settings;
    scaled.jiggle_translation *= amplitude;
    scaled.jiggle_rotation *= amplitude;
    Survival row;
    row.amplitude = amplitude;
    row.seeds = settings.survival_seeds;
    for (int k = 0; k < row.seeds; ++k) {
      const std::uint64_t own =
          Random(seed, "survival", {static_cast<std::uint64_t>(rows.size()), static_cast<std::uint64_t>(k)}).bits();
      const TrialResult trial = run_trial(robot, workspace, q, X_WP, X_WO, 0, scaled, own);
      row.held += trial.outcome == Outcome::held;
      row.survival += trial.survival / row.seeds;
      row.displacement += trial.displacement / row.seeds;
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace primo::physics

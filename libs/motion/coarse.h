// A path over few, long steps: the same cost at a fraction of its price, to tell basins apart before they are refined.
//
// Coarse step k stands for the fine steps about it: its tasks are those of the fine step it ends at, weighted by how
// many fine steps it stands for, and its control cost is the same integral of q̈ᵀ H q̈ over longer intervals. The last
// step stands once for the fine step T, whose tasks may be its own, and for the steps before it as step T − 1 has them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "motion/trajectory_problem.h"

namespace primo::motion {

/// The tasks of a path of `steps` coarse steps. The fine problem and its stages must outlive it.
class CoarseStages final : public StageCosts {
 public:
  /// @pre 1 ≤ steps ≤ fine.steps.
  CoarseStages(const TrajectoryProblem& fine, StageCosts& stages, int steps);

  /// The problem that these stages belong to.
  const TrajectoryProblem& problem() const { return problem_; }
  double evaluate(int k, const Eigen::VectorXd& q, const Eigen::VectorXd& v, StageModel* model) override;

  /// The cubic splines through q_0 and the coarse path (n × K) at the fine steps (n × T), with v_0 at the start and no
  /// acceleration at the end: of all paths through these points, those of the least ∫ q̈².
  Eigen::MatrixXd refine(const Eigen::MatrixXd& q) const;

  /// The points of a fine path (n × T) that coarse steps end at (n × K).
  Eigen::MatrixXd sample(const Eigen::MatrixXd& q) const;

 private:
  const TrajectoryProblem& fine_;
  StageCosts& stages_;
  TrajectoryProblem problem_;
  std::vector<int> at_;         // by k − 1: the fine step that coarse step k ends at
  std::vector<double> weight_;  // by k − 1: how many fine steps it stands for
  StageModel before_;           // workspace
};

}  // namespace primo::motion

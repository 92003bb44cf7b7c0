// A place in full physics: the grip before the motion; opening, retreat and rest after it.
#include <algorithm>
#include <cmath>

#include "physics/execution.h"
#include "physics/place_end.h"

namespace primo::physics {
namespace {

constexpr double kHangSeconds = 0.05;

Execution diverged_at(const Simulation& simulation, Execution execution, const char* stage) {
  return finish(simulation, std::move(execution), Outcome::unstable,
                std::string("the simulation diverged while ") + stage, 0);
}

/// Back along the approach with the fingers opening before. False: diverged.
bool retreat(const robot::Robot& robot, Simulation& simulation, const Eigen::VectorXd& q_end) {
  constexpr int kParts = 20;
  const Eigen::VectorXd holding = simulation.finger_targets();
  const Eigen::Vector3d back = -kRetreat * robot.pose(robot.forward(q_end), robot.grasp_frame()).linear().col(2);
  const Eigen::MatrixXd path = straight_path(robot, q_end, back, kParts);
  const double row = row_seconds(robot, path, kRetreatSeconds / kParts);
  const int steps = simulation.steps_in(kOpenSeconds + kParts * row);
  for (int k = 0; k < steps; ++k) {
    const double time = k * simulation.timestep();
    simulation.set_finger_targets(opening_targets(robot, holding, time));
    const Reference reference = reference_at(path, row, time - kOpenSeconds);
    if (!simulation.step(reference, Simulation::Fingers::hold, false)) return false;
  }
  return true;
}

/// Until nothing moves any more, then through the window in which contacts count. False: diverged.
bool rest(Simulation& simulation, PlaceObserver& observer, const Eigen::VectorXd& q, double slow) {
  const int patience = simulation.steps_in(kContactSeconds);
  int still = 0;
  for (int k = simulation.steps_in(kRestSeconds); k > 0 && still < patience; --k) {
    if (!simulation.step(at_rest(q), Simulation::Fingers::hold, false)) return false;
    still = observer.speed(simulation.model().get(), simulation.data()) < slow ? still + 1 : 0;
  }
  for (int k = patience; k > 0; --k) {
    if (!simulation.step(at_rest(q), Simulation::Fingers::hold, false)) return false;
    observer.note_contacts(simulation.model().get(), simulation.data());
  }
  simulation.update();
  return true;
}

}  // namespace

bool grip_held(Simulation& simulation, const JudgeRequest& request) {
  const Eigen::VectorXd q = request.q.row(0).transpose();
  simulation.pin(true);
  const int patience = simulation.steps_in(0.03);
  int still = 0;
  for (int k = simulation.steps_in(request.settings.close_seconds); k > 0 && still < patience; --k) {
    if (!simulation.step(at_rest(q), Simulation::Fingers::close, false)) return false;
    still = simulation.still() ? still + 1 : 0;
  }
  simulation.freeze_fingers(q);
  simulation.pin(false);
  for (int k = simulation.steps_in(kHangSeconds); k > 0; --k) {
    if (!simulation.step(at_rest(q), Simulation::Fingers::hold, false)) return false;
  }
  return true;
}

Execution open_and_retreat(const robot::Robot& robot, Simulation& simulation, Execution execution,
                           const JudgeRequest& request) {
  const Eigen::VectorXd q_end = request.q.row(request.q.rows() - 1).transpose();
  simulation.update();
  auto& trial = execution.trial;
  const PlaceBodies bodies(simulation.model(), request.scenario);
  PlaceObserver observer(request.scenario, simulation.joints(), bodies);
  const Stacking arrived = observer.end(simulation.model().get(), simulation.data()).found;
  trial.displacement = (simulation.X_PO().translation() - trial.X_PO.translation()).norm();
  const bool dropped = trial.displacement > request.settings.max_displacement;
  simulation.use_multiccd();
  if (!retreat(robot, simulation, q_end)) return diverged_at(simulation, std::move(execution), "the hand withdrew");
  if (!rest(simulation, observer, Eigen::VectorXd(simulation.q()), 0.1 * request.settings.place_speed)) {
    return diverged_at(simulation, std::move(execution), "the object came to rest");
  }
  PlaceEnd end = observer.end(simulation.model().get(), simulation.data());
  end.planned = arrived;
  PlaceDecision decision = decide_place(end, request.settings);
  if (dropped && decision.outcome != Outcome::placed) decision.reason += "; it slipped in the hand on the way";
  trial.criteria = place_criteria(end, request.settings);
  return finish(simulation, std::move(execution), decision.outcome, decision.reason, decision.score);
}

}  // namespace primo::physics

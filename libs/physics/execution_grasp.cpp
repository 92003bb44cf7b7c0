// After the motion of a grasp in full physics: close, lift, hold.
#include <algorithm>
#include <string>

#include "physics/execution.h"

namespace primo::physics {
namespace {

constexpr double kLiftSeconds = 1.0;
constexpr double kLiftHeight = 0.1;  // m
constexpr double kHoldSeconds = 0.5;
constexpr double kLifted = 0.02;  // m above where it stood: carried by the hand, not by the table

/// Lifts and holds. The target's displacement in the hand counts from the closing.
Execution lift_and_hold(const robot::Robot& robot, Simulation& simulation, Execution execution,
                        const Eigen::VectorXd& q_end, const JudgeSettings& settings) {
  constexpr int kParts = 20;
  const Eigen::MatrixXd path = straight_path(robot, q_end, {0, 0, kLiftHeight}, kParts);
  const Pose X_start = simulation.X_PO();
  const double height = simulation.object_height();
  const double row = row_seconds(robot, path, kLiftSeconds / kParts);
  const int steps = simulation.steps_in(kParts * row + kHoldSeconds), window = simulation.steps_in(0.05);
  bool opposed = false;
  for (int k = 0; k < steps; ++k) {
    const Reference reference = reference_at(path, row, k * simulation.timestep());
    if (!simulation.step(reference, Simulation::Fingers::hold, false)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while lifting", 0);
    }
    if (k % 5 != 0 && k + window < steps) continue;
    auto& trial = execution.trial;
    trial.displacement = std::max(trial.displacement, (simulation.X_PO().translation() - X_start.translation()).norm());
    trial.survival = static_cast<double>(k + 1) / steps;
    if (k + window >= steps) opposed = opposed || simulation.grip().opposed();
    if (trial.displacement > settings.max_displacement) {
      return finish(simulation, std::move(execution), Outcome::fell_in_jiggle,
                    "the object slipped out of the hand while it was lifted", 0.4 + 0.4 * trial.survival);
    }
  }
  simulation.update();
  if (!opposed) {
    return finish(simulation, std::move(execution), Outcome::contact_lost,
                  std::string("after lifting ") + simulation.holders() + " no longer hold the object", 0.8);
  }
  if (simulation.object_height() < height + kLifted) {
    return finish(simulation, std::move(execution), Outcome::contact_lost,
                  "the arm could not lift the object off its support", 0.8);
  }
  const double score = 1.0 - 0.2 * std::min(1.0, execution.trial.displacement / settings.max_displacement);
  return finish(simulation, std::move(execution), Outcome::held, "the object was lifted and held", score);
}

}  // namespace

Execution close_and_lift(const robot::Robot& robot, Simulation& simulation, Execution execution,
                         const JudgeRequest& request, const std::string& target, double position_error) {
  const Eigen::VectorXd q_end = request.q.row(request.q.rows() - 1).transpose();
  for (int k = simulation.steps_in(request.settings.close_seconds); k > 0; --k) {
    if (!simulation.step(at_rest(q_end), Simulation::Fingers::close, false)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while closing", 0);
    }
  }
  simulation.freeze_fingers(q_end);
  const Grip grip = simulation.grip();
  if (grip.parts() == 0) {
    return finish(simulation, std::move(execution), Outcome::no_contact, "the closed fingers do not touch the object",
                  miss_score(position_error));
  }
  if (!grip.opposed()) {
    return finish(simulation, std::move(execution), Outcome::not_opposed, grip.complaint(), 0.25 + 0.05 * grip.parts());
  }
  Execution done = lift_and_hold(robot, simulation, std::move(execution), q_end, request.settings);
  if (done.trial.outcome == Outcome::held) done.world.in_hand.insert(target);
  return done;
}

}  // namespace primo::physics

#include "physics/execution.h"

#include <algorithm>

#include "physics/aftermath.h"

namespace primo::physics {
namespace {

constexpr double kSettleSeconds = 0.1;

}  // namespace

Execution finish(const Simulation& simulation, Execution execution, Outcome outcome, const std::string& reason,
                 double score) {
  execution.trial.outcome = outcome;
  execution.trial.reason = reason;
  execution.trial.score = score;
  execution.trial.steps = simulation.steps();
  execution.contacts = simulation.contacts();
  if (outcome == Outcome::unstable) {
    execution.trial.reason += unstable_at(simulation.steps(), simulation.timestep());
  } else {
    execution.trial.X_PO = simulation.X_PO();
    execution.world = simulation.world();
  }
  return execution;
}

Result<Execution> execute(const robot::Robot& robot, const JudgeRequest& request, const std::string& target,
                          double position_error, Recording* recording) {
  PRIMO_ASSIGN(Model model, assemble(&robot, request.scenario, {.timestep = request.settings.timestep, .extra = {}}));
  Simulation simulation(robot, request, std::move(model), target, recording);
  Execution execution;
  execution.world = snapshot(request.scenario);
  const bool place = request.scenario.held.has_value();
  if (place) {
    if (!grip_held(simulation, request)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while gripping", 0);
    }
    simulation.update();
    execution.trial.X_PO = simulation.X_PO();
  }
  const auto fingers = place ? Simulation::Fingers::hold : Simulation::Fingers::follow;
  const double duration = request.dt * static_cast<double>(request.q.rows() - 1);
  const int moving = simulation.steps_in(duration), settling = simulation.steps_in(kSettleSeconds);
  for (int k = 0; k < moving + settling; ++k) {
    const double time = k * simulation.timestep();
    const Reference reference = reference_at(request.q, request.dt, time);
    if (!simulation.step(reference, fingers, true)) {
      return finish(simulation, std::move(execution), Outcome::unstable, "the simulation diverged while moving", 0);
    }
    execution.tracking_error = std::max(execution.tracking_error, simulation.tracking_error(reference));
  }
  if (place) return open_and_retreat(robot, simulation, std::move(execution), request);
  return close_and_lift(robot, simulation, std::move(execution), request, target, position_error);
}

}  // namespace primo::physics

#include "wire/check.h"
#include "wire/parts.h"
#include "wire/wire.h"

namespace primo::wire {
namespace {

// Beside the overloads below, not hidden by them.
using wire::from_wire;
using wire::to_wire;

msg::OptimizerSettings to_wire(const optim::OptimizerSettings& settings) {
  msg::OptimizerSettings out;
  out.name(settings.name);
  out.evaluations(settings.evaluations);
  out.population(settings.population);
  out.sigma(settings.sigma);
  out.seed(settings.seed);
  out.restart(settings.restart);
  out.on_stagnation(settings.on_stagnation);
  out.patience(settings.patience);
  out.least_rise(settings.least_rise);
  return out;
}

Result<optim::OptimizerSettings> from_wire(const msg::OptimizerSettings& message) {
  optim::OptimizerSettings out;
  out.name = message.name();
  out.evaluations = message.evaluations();
  out.population = message.population();
  out.sigma = message.sigma();
  out.seed = message.seed();
  out.restart = message.restart();
  out.on_stagnation = message.on_stagnation();
  out.patience = message.patience();
  out.least_rise = message.least_rise();
  PRIMO_TRY(check_fields("optimizer", out));
  return out;
}

Status check_name(const std::string& field, const std::string& text) {
  if (text.empty()) return malformed(field, "is empty");
  return check_text(field, text);
}

}  // namespace

msg::OptimizeGoal to_wire(const study::OptimizeGoal& goal) {
  msg::OptimizeGoal out;
  out.study(goal.study);
  out.part(goal.part);
  out.round(goal.round);
  out.directory(goal.directory);
  out.primitive(to_wire(goal.primitive));
  for (const scene::Scenario& scenario : goal.scenarios) out.scenarios().push_back(to_wire(scenario));
  for (const scene::SceneEstimate& estimate : goal.estimates) out.estimates().push_back(to_wire(estimate));
  out.drawn(goal.drawn);
  out.held_out(goal.held_out);
  out.desired(to_wire(goal.desired));
  out.optimizer(to_wire(goal.optimizer));
  out.algorithms(goal.algorithms);
  out.restarts(goal.restarts);
  out.judge(to_wire(goal.judge));
  out.seed(goal.seed);
  out.settings(goal.settings);
  return out;
}

Result<study::OptimizeGoal> from_wire(const msg::OptimizeGoal& message) {
  study::OptimizeGoal out;
  PRIMO_TRY(check_name("goal.study", message.study()));
  out.study = message.study();
  PRIMO_TRY(check_text("goal.part", message.part()));
  out.part = message.part();
  if (message.round() < 0) return malformed("goal.round", "is negative");
  out.round = message.round();
  PRIMO_TRY(check_text("goal.directory", message.directory()));
  out.directory = message.directory();
  PRIMO_ASSIGN(out.primitive, from_wire(message.primitive()));
  PRIMO_TRY(check_count("goal.scenarios", message.scenarios().size()));
  if (message.scenarios().size() != message.estimates().size()) {
    return malformed("goal", "has " + std::to_string(message.scenarios().size()) + " scenarios but " +
                                 std::to_string(message.estimates().size()) + " estimates");
  }
  for (const msg::Scenario& scenario : message.scenarios()) {
    PRIMO_ASSIGN(scene::Scenario converted, from_wire(scenario));
    out.scenarios.push_back(std::move(converted));
  }
  for (const msg::SceneEstimate& estimate : message.estimates()) {
    PRIMO_ASSIGN(scene::SceneEstimate converted, from_wire(estimate));
    out.estimates.push_back(std::move(converted));
  }
  if (message.drawn() < 0) return malformed("goal.drawn", "is negative");
  out.drawn = message.drawn();
  if (message.held_out() < 0) return malformed("goal.held_out", "is negative");
  out.held_out = message.held_out();
  PRIMO_ASSIGN(out.desired, from_wire("goal.desired", message.desired()));
  PRIMO_ASSIGN(out.optimizer, from_wire(message.optimizer()));
  PRIMO_TRY(check_texts("goal.algorithms", message.algorithms()));
  out.algorithms = message.algorithms();
  if (message.restarts() < 1 || message.restarts() > 100000) return malformed("goal.restarts", "must be 1 to 100000");
  out.restarts = message.restarts();
  PRIMO_ASSIGN(out.judge, from_wire(message.judge()));
  out.seed = message.seed();
  PRIMO_TRY(check_text("goal.settings", message.settings()));
  out.settings = message.settings();
  return out;
}

msg::OptimizedPrimitive to_wire(const study::OptimizeResult& result) {
  msg::OptimizedPrimitive out;
  out.action(result.primitive.action);
  out.study(result.study);
  out.round(result.round);
  out.primitive(to_wire(result.primitive));
  out.gamma(result.gamma);
  out.success(to_wire(result.success));
  out.evaluations(result.evaluations);
  return out;
}

Result<study::OptimizeResult> from_wire(const msg::OptimizedPrimitive& message) {
  if (!message.error().empty()) {
    PRIMO_TRY(check_text("primitive.error", message.error()));
    return Error{Code::failed, message.error()};
  }
  study::OptimizeResult out;
  PRIMO_TRY(check_name("primitive.study", message.study()));
  out.study = message.study();
  out.round = message.round();
  PRIMO_ASSIGN(out.primitive, from_wire(message.primitive()));
  PRIMO_TRY(check_finite("primitive.gamma", message.gamma()));
  out.gamma = message.gamma();
  PRIMO_ASSIGN(out.success, from_wire("primitive.success", message.success()));
  out.evaluations = message.evaluations();
  return out;
}

}  // namespace primo::wire

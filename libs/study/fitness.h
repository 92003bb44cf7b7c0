// γ, the fitness of a motion primitive (paper, IV.B and Algorithm 1): the mean over K training scenarios of g(x̄), which
// scores one trajectory by the rule's outcome and by the margins of its path.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/backend.h"

namespace primo::study {

/// The weights of g(x̄). Half of the weight is success itself, half is graded: with success alone nearly every random ρ
/// scores exactly 0 and a search has nothing to follow; with the graded terms alone the search finds motions that score
/// well and never succeed.
struct FitnessSettings {
  double success = 0.5;
  double score = 0.5;
  double clearance = 0.25;
  double clearance_from = -0.01, clearance_to = 0.01;
  double target_clearance = 0.25;
  double target_clearance_from = -0.02, target_clearance_to = -0.006;
  double limits = 0.1;
  double speed = 0.1;
  double speed_from = 1.5;
  double speed_range = 2.0;
  double path_length = 0.02;
  double path_length_cap = 50;
  double iterations = 0.001;
  // How the graded terms hang together (docs/decisions/0504); 0 leaves each on its own.
  double clean_share = 0.8;  // of the score, what counts only as far as the path is clean
  double near = 0;           // m; the clearances count by exp(−e/near), e the grasp centre's distance at the end
  template <class V>
  void visit(V&& v) {
    v("success", success, {.help = "weight of strict success with the rule's desired outcome", .min = 0, .max = 1e3});
    v("score", score, {.help = "weight of the judge's graded score", .min = 0, .max = 1e3});
    v("clearance", clearance, {.help = "weight of the clearance to obstacles and table", .min = 0, .max = 1e3});
    v("clearance_from", clearance_from, {.help = "clearance that counts 0", .unit = "m", .min = -1, .max = 1});
    v("clearance_to", clearance_to, {.help = "clearance that counts fully", .unit = "m", .min = -1, .max = 1});
    v("target_clearance", target_clearance, {.help = "weight of the clearance hand to target", .min = 0, .max = 1e3});
    v("target_clearance_from", target_clearance_from,
      {.help = "distance that counts 0", .unit = "m", .min = -1, .max = 1});
    v("target_clearance_to", target_clearance_to,
      {.help = "distance that counts fully", .unit = "m", .min = -1, .max = 1});
    v("limits", limits, {.help = "weight of joint limits kept", .min = 0, .max = 1e3});
    v("speed", speed, {.help = "loss per rad/s of arm speed above speed_from", .min = 0, .max = 1e3});
    v("speed_from", speed_from, {.unit = "rad/s", .min = 0, .max = 100});
    v("speed_range", speed_range, {.help = "excess that is counted at most", .unit = "rad/s", .min = 0, .max = 100});
    v("path_length", path_length, {.help = "loss per rad of path", .min = 0, .max = 1e3});
    v("path_length_cap", path_length_cap,
      {.help = "length that is counted at most", .unit = "rad", .min = 0, .max = 1e4});
    v("clean_share", clean_share,
      {.help = "share of the score that counts only as far as the path is clean", .min = 0, .max = 1});
    v("near", near,
      {.help = "distance of hand to object at which clearances count 1/e; 0: anywhere",
       .unit = "m",
       .min = 0,
       .max = 10});
    v("iterations", iterations, {.help = "loss per iteration of the planner", .min = 0, .max = 1e3});
  }
  Status validate() const;
};

/// What γ is the mean of.
enum class Signal {
  mixed,   ///< half success, half graded: the weights of FitnessSettings
  graded,  ///< without success
  binary,  ///< success alone: 1 or 0
};

/// The variable that stands for the i-th argument of an action in lifted literals: X, Y, Z, U, V, W, A6, A7, …
std::string argument_variable(std::size_t i);

/// Whether the verdict's `after` holds the desired literals, their variables X, Y, … bound to the action's arguments.
/// Other variables are deictic, and an effect is about what it changes: a negated literal must have become false for
/// every binding that held in `before` (at least one), a positive one must hold for some object.
bool holds_desired(const physics::Verdict& verdict, const std::vector<symbols::Literal>& desired,
                   const std::vector<std::string>& action);

/// Success as the symbolic level counts it: the strict verdict, and the desired outcome holds.
bool succeeded(const RolloutResult& result, const std::vector<symbols::Literal>& desired,
               const std::vector<std::string>& action);

/// g(x̄) of one trajectory. Always finite; a rollout without a plan scores worst_fitness().
double trajectory_fitness(const RolloutResult& result, bool success, const FitnessSettings& settings);

/// What γ is the mean of. binary: 1 or 0; graded: trajectory_fitness() as if nothing succeeded.
double signal(const RolloutResult& result, bool success, Signal kind, const FitnessSettings& settings);

/// The upper bound of signal().
double best_signal(Signal kind, const FitnessSettings& settings);

/// The lower bound of trajectory_fitness().
double worst_fitness(const FitnessSettings& settings, int max_iterations);

/// γ: the mean of g over the scenarios (Algorithm 1). @pre not empty.
double fitness(std::span<const double> g);

}  // namespace primo::study

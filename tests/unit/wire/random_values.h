// Library values drawn at random, within the bounds that files keep too.
#pragma once

#include <string>
#include <vector>

#include "core/random.h"
#include "study/backend.h"

namespace primo::wire {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed, "wire test") {}

  int integer(int low, int high) {
    return low + static_cast<int>(random_.below(static_cast<std::uint64_t>(high - low + 1)));
  }
  double real(double low = -3, double high = 3) { return random_.uniform(low, high); }
  bool coin() { return random_.below(2) == 1; }
  std::uint64_t bits() { return random_.bits(); }
  std::string word() {
    std::string text;
    for (int i = integer(1, 12); i > 0; --i) text += static_cast<char>('a' + integer(0, 25));
    return text;
  }
  std::vector<std::string> words() {
    std::vector<std::string> all(static_cast<std::size_t>(integer(0, 4)));
    for (auto& text : all) text = word();
    return all;
  }
  std::vector<double> reals(int most, double low = -3, double high = 3) {
    std::vector<double> all(static_cast<std::size_t>(integer(0, most)));
    for (auto& value : all) value = real(low, high);
    return all;
  }
  Eigen::Vector3d vector(double low = -3, double high = 3) {
    return {real(low, high), real(low, high), real(low, high)};
  }
  Eigen::MatrixXd matrix(int rows, int cols) {
    Eigen::MatrixXd m(rows, cols);
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < cols; ++j) m(i, j) = random_.normal();
    }
    return m;
  }
  Pose pose_of() { return pose(vector(), vector()); }

  symbols::Literal literal(bool may_be_negated = true) {
    symbols::Literal out{word(), words(), may_be_negated && coin()};
    if (coin()) return out;
    out.relation = static_cast<symbols::Relation>(integer(1, may_be_negated ? 3 : 1));
    out.value = integer(-1000, 1000);
    return out;
  }
  std::vector<symbols::Literal> literals() {
    std::vector<symbols::Literal> all(static_cast<std::size_t>(integer(0, 4)));
    for (auto& one : all) one = literal();
    return all;
  }
  symbols::State state() {
    symbols::State all;
    for (int i = integer(0, 6); i > 0; --i) all.insert(literal(false));
    return all;
  }

  scene::Table table() { return {word(), vector(), {real(0.1, 4), real(0.1, 4)}, real(0.01, 0.4)}; }
  scene::Object object() {
    scene::Object out;
    out.name = word();
    out.type = coin() ? ShapeType::cylinder : ShapeType::box;
    out.radius = real(0.01, 0.4);
    out.height = real(0.01, 0.9);
    out.half_extents = vector(0.01, 0.9);
    out.position = vector();
    out.rpy = vector();
    out.mass = real(0.1, 10);
    return out;
  }
  scene::Camera camera() {
    scene::Camera out;
    out.position = vector();
    out.look_at = vector();
    out.fov_y = real(0.1, 2);
    out.width = integer(8, 1280);
    out.height = integer(8, 1024);
    out.depth_noise = real(0, 0.1);
    return out;
  }
  scene::Scenario scenario() {
    scene::Scenario out;
    out.name = word();
    out.table = table();
    for (int i = integer(0, 4); i > 0; --i) out.objects.push_back(object());
    for (int i = integer(0, 2); i > 0; --i) out.cameras.push_back(camera());
    out.robot_start = reals(14);
    out.action = words();
    out.camera_seed = bits();
    if (coin()) out.held = scene::Held{word(), vector(-1, 1), vector()};
    return out;
  }
  scene::PointCloud cloud() {
    scene::PointCloud out;
    out.X_WC = pose_of();
    for (int i = integer(0, 50); i > 0; --i) out.points.push_back(vector().cast<float>());
    return out;
  }
  scene::SceneEstimate estimate() {
    scene::SceneEstimate out;
    out.scene = word();
    out.table = table();
    for (int i = integer(0, 4); i > 0; --i) {
      scene::ObjectEstimate one;
      one.name = word();
      one.type = static_cast<ShapeType>(integer(0, 3));
      one.X_WO = pose_of();
      one.shape = {static_cast<ShapeType>(integer(0, 3)), vector(0, 1)};
      one.residual = real(0, 0.1);
      one.points = integer(0, 10000);
      out.objects.push_back(one);
    }
    for (int i = integer(0, 100); i > 0; --i) out.octree.push_back(static_cast<std::uint8_t>(bits()));
    out.resolution = real(0.001, 0.1);
    return out;
  }
  motion::Primitive primitive() {
    motion::Primitive out;
    out.name = word();
    out.action = word();
    out.steps = integer(1, 1000);
    out.duration = real(0.1, 60);
    out.solver = word();
    out.start = coin() ? "rest" : "ik";
    out.max_iterations = integer(1, 10000);
    out.tolerance = real(1e-6, 1);
    out.control_rate = real(1e-3, 1e3);
    for (int i = integer(0, 5); i > 0; --i) {
      motion::Task task;
      task.name = word();
      task.variable = word();
      task.profile = static_cast<motion::Profile>(integer(0, 6));
      task.at = real(0, 1);
      task.rho = real(0, 1e9);
      task.rho_late = real(0, 1e9);
      task.target = reals(3);
      for (int k = integer(0, 3); k > 0; --k) task.parameters[word()] = real();
      task.optimize = coin();
      for (int k = integer(0, 2); k > 0; --k) {
        task.search[word()] = {coin(), static_cast<motion::Scale>(integer(0, 2)), real(0, 1), real(1, 1e9)};
      }
      for (int k = integer(0, 3); k > 0; --k) task.of[word()] = word();
      task.from_start = coin();
      out.tasks.push_back(task);
    }
    return out;
  }
  motion::PlanRequest plan_request() {
    motion::PlanRequest out{estimate(), words(), reals(14), primitive(), coin(), matrix(integer(0, 5), 14)};
    if (coin()) out.held = motion::HeldObject{word(), pose_of()};
    return out;
  }
  motion::Plan plan() {
    motion::Plan out;
    out.status = static_cast<motion::PlanStatus>(integer(0, 6));
    out.reason = word();
    const int n = integer(1, 14), steps = integer(0, 20);
    for (int i = 0; i < n; ++i) out.trajectory.joints.push_back(word());
    out.trajectory.dt = real(0.01, 0.1);
    out.trajectory.q = matrix(steps + 1, n);
    for (int t = 0; t < steps; ++t) {
      out.gains.K.push_back(matrix(n, 2 * n));
      out.gains.k.emplace_back(matrix(n, 1).col(0));
    }
    out.iterations = integer(0, 100);
    out.rejected = integer(0, 100);
    out.evaluations = integer(0, 100);
    out.cost_initial = real();
    out.cost_final = real();
    out.cost_control = real();
    for (int i = integer(0, 4); i > 0; --i) out.cost_tasks.push_back({word(), real()});
    out.gradient_norm = real();
    out.lambda = real();
    out.start = word();
    return out;
  }
  physics::JudgeSettings judge_settings() {
    physics::JudgeSettings out;
    out.timestep = real(1e-4, 0.01);
    out.close_seconds = real(0.05, 5);
    out.jiggle_seconds = real(0, 30);
    out.jiggle_frequency = real(0.1, 20);
    out.jiggle_translation = real(0, 0.2);
    out.jiggle_rotation = real(0, 1);
    out.max_displacement = real(0.001, 0.5);
    out.max_penetration = real(0, 0.05);
    out.clearance_margin = real(-0.1, 0.2);
    out.target_margin = real(-0.1, 0.1);
    out.max_joint_speed = real(0.1, 50);
    out.limit_margin = real(-1, 1);
    out.place_criterion = coin() ? physics::PlaceCriterion::full : physics::PlaceCriterion::paper;
    out.place_height = real(0.001, 0.1);
    out.place_offset = real(0.001, 0.5);
    out.place_tilt = real(0.001, 1.5);
    out.place_speed = real(1e-4, 1);
    out.survival_amplitudes.clear();
    for (int i = integer(0, 5); i > 0; --i) out.survival_amplitudes.push_back(real(0, 10));
    out.survival_seeds = integer(0, 1000);
    return out;
  }
  physics::JudgeRequest judge_request() {
    physics::JudgeRequest out;
    out.scenario = scenario();
    out.q = matrix(integer(0, 20), integer(1, 14));
    out.dt = real(0.01, 0.1);
    out.planner_iterations = integer(0, 100);
    for (int i = integer(0, 3); i > 0; --i) out.K.push_back(matrix(3, 6));
    out.seed = bits();
    out.mode = coin() ? physics::Mode::final_pose : physics::Mode::execute;
    out.settings = judge_settings();
    return out;
  }
  physics::Verdict verdict() {
    physics::Verdict out;
    out.success = coin();
    out.final_pose_success = coin();
    out.path_clean = coin();
    out.outcome = static_cast<physics::Outcome>(integer(0, 12));
    out.reason = word();
    for (double* value : {&out.score, &out.displacement, &out.survival, &out.position_error, &out.clearance,
                          &out.target_clearance, &out.limit_margin, &out.max_speed, &out.path_length}) {
      *value = real();
    }
    for (int i = integer(0, 6); i > 0; --i) out.criteria.push_back({word(), real(), real(), coin()});
    out.before = state();
    out.after = state();
    out.objects = words();
    out.steps = integer(0, 10000);
    for (int i = integer(0, 4); i > 0; --i) {
      const int seeds = integer(0, 50);
      out.survivals.push_back({real(), seeds, integer(0, seeds), real(), real()});
    }
    for (int i = integer(0, 6); i > 0; --i) out.contacts.push_back({word(), word(), real(), real(), real()});
    out.unlisted_contacts = integer(0, 100);
    return out;
  }
  symbols::Experience experience() { return {word(), words(), state(), literal(false), state()}; }
  rules::RuleSet rule_set() {
    rules::RuleSet out;
    for (int i = integer(0, 4); i > 0; --i) {
      rules::Rule rule;
      rule.action = literal(false);
      rule.context = literals();
      for (int k = integer(0, 3); k > 0; --k) rule.outcomes.push_back({real(0, 1), literals(), integer(0, 100)});
      rule.noise = real(0, 1);
      rule.noise_count = integer(0, 100);
      rule.examples = integer(0, 100);
      out.rules.push_back(rule);
    }
    for (int i = integer(0, 3); i > 0; --i)
      out.defaults[word()] = {real(0, 1), real(0, 1), integer(0, 9), integer(0, 9)};
    for (int i = integer(0, 2); i > 0; --i) {
      const std::string head = i == 1 ? "top(X)" : "bottom(X)";
      out.derived.push_back(symbols::definition_from_text(head + " := not exists Y: on(Y,X)").value());
    }
    return out;
  }
  study::OptimizeGoal goal() {
    study::OptimizeGoal out;
    out.study = word();
    out.round = integer(0, 9);
    out.directory = word();
    out.primitive = primitive();
    for (int i = integer(0, 3); i > 0; --i) {
      out.scenarios.push_back(scenario());
      out.estimates.push_back(estimate());
    }
    out.drawn = integer(0, 6);
    out.held_out = integer(0, 3);
    out.desired = literals();
    out.optimizer.name = word();
    out.optimizer.evaluations = integer(1, 10000);
    out.optimizer.population = integer(0, 100);
    out.optimizer.sigma = real(0.01, 1);
    out.optimizer.seed = bits();
    out.optimizer.restart = integer(0, 10);
    out.optimizer.on_stagnation = std::vector<std::string>{"ipop", "bipop", "again", "stop"}[integer(0, 3)];
    out.optimizer.patience = integer(0, 100);
    out.optimizer.least_rise = real(0, 1);
    out.algorithms = words();
    out.restarts = integer(1, 10);
    out.judge = judge_settings();
    out.seed = bits();
    out.settings = word();
    return out;
  }
  study::OptimizeResult result() {
    study::OptimizeResult out;
    out.study = word();
    out.round = integer(0, 9);
    out.primitive = primitive();
    out.gamma = real();
    out.success.trials = integer(0, 100);
    out.success.successes = integer(0, static_cast<int>(out.success.trials));
    out.evaluations = integer(0, 10000);
    return out;
  }

 private:
  Random random_;
};

}  // namespace primo::wire

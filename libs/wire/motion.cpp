#include "motion/task_variables.h"
#include "wire/check.h"
#include "wire/parts.h"
#include "wire/wire.h"

namespace primo::wire {
namespace {

// Beside the overloads below, not hidden by them.
using wire::from_wire;
using wire::to_wire;

std::vector<msg::NamedNumber> to_wire(const std::map<std::string, double>& numbers) {
  std::vector<msg::NamedNumber> out;
  for (const auto& [name, value] : numbers) {
    msg::NamedNumber entry;
    entry.name(name);
    entry.value(value);
    out.push_back(std::move(entry));
  }
  return out;
}

Result<std::map<std::string, double>> from_wire(const std::string& field,
                                                const std::vector<msg::NamedNumber>& numbers) {
  PRIMO_TRY(check_count(field, numbers.size()));
  std::map<std::string, double> out;
  for (const msg::NamedNumber& entry : numbers) {
    PRIMO_TRY(check_text(field, entry.name()));
    if (!out.emplace(entry.name(), entry.value()).second) return malformed(field, "has '" + entry.name() + "' twice");
  }
  return out;
}

std::vector<msg::NamedText> to_wire(const std::map<std::string, std::string>& texts) {
  std::vector<msg::NamedText> out;
  for (const auto& [name, value] : texts) {
    msg::NamedText entry;
    entry.name(name);
    entry.value(value);
    out.push_back(std::move(entry));
  }
  return out;
}

Result<std::map<std::string, std::string>> from_wire(const std::string& field,
                                                     const std::vector<msg::NamedText>& texts) {
  PRIMO_TRY(check_count(field, texts.size()));
  std::map<std::string, std::string> out;
  for (const msg::NamedText& entry : texts) {
    PRIMO_TRY(check_text(field, entry.name()));
    PRIMO_TRY(check_text(field, entry.value()));
    if (!out.emplace(entry.name(), entry.value()).second) return malformed(field, "has '" + entry.name() + "' twice");
  }
  return out;
}

std::vector<msg::EntrySearch> to_wire(const std::map<std::string, motion::Search>& searches) {
  std::vector<msg::EntrySearch> out;
  for (const auto& [entry, search] : searches) {
    msg::EntrySearch one;
    one.entry(entry);
    one.keep(search.fixed);
    one.scale(static_cast<std::uint8_t>(search.scale));
    one.min(search.min);
    one.max(search.max);
    out.push_back(std::move(one));
  }
  return out;
}

Result<std::map<std::string, motion::Search>> from_wire(const std::string& field,
                                                        const std::vector<msg::EntrySearch>& searches) {
  PRIMO_TRY(check_count(field, searches.size()));
  std::map<std::string, motion::Search> out;
  for (const msg::EntrySearch& one : searches) {
    PRIMO_TRY(check_text(field, one.entry()));
    motion::Search search;
    search.fixed = one.keep();
    PRIMO_ASSIGN(search.scale, enum_from<motion::Scale>(field + ".scale", one.scale()));
    search.min = one.min();
    search.max = one.max();
    if (!out.emplace(one.entry(), search).second) return malformed(field, "has '" + one.entry() + "' twice");
  }
  return out;
}

msg::PrimitiveTask to_wire(const motion::Task& task) {
  msg::PrimitiveTask out;
  out.name(task.name);
  out.variable(task.variable);
  out.profile(static_cast<std::uint8_t>(task.profile));
  out.at(task.at);
  out.rho(task.rho);
  out.rho_late(task.rho_late);
  out.target(task.target);
  out.parameters(to_wire(task.parameters));
  out.optimize(task.optimize);
  out.of(to_wire(task.of));
  out.from_start(task.from_start);
  out.search(to_wire(task.search));
  return out;
}

Result<motion::Task> from_wire(const std::string& field, const msg::PrimitiveTask& task) {
  motion::Task out;
  out.name = task.name();
  out.variable = task.variable();
  PRIMO_ASSIGN(out.profile, enum_from<motion::Profile>(field + ".profile", task.profile()));
  out.at = task.at();
  out.rho = task.rho();
  out.rho_late = task.rho_late();
  out.target = task.target();
  PRIMO_ASSIGN(out.parameters, from_wire(field + ".parameters", task.parameters()));
  out.optimize = task.optimize();
  PRIMO_ASSIGN(out.of, from_wire(field + ".of", task.of()));
  out.from_start = task.from_start();
  PRIMO_ASSIGN(out.search, from_wire(field + ".search", task.search()));
  return out;
}

}  // namespace

msg::Primitive to_wire(const motion::Primitive& primitive) {
  msg::Primitive out;
  out.name(primitive.name);
  out.action(primitive.action);
  out.steps(primitive.steps);
  out.duration(primitive.duration);
  out.solver(primitive.solver);
  out.start(primitive.start);
  out.max_iterations(primitive.max_iterations);
  out.tolerance(primitive.tolerance);
  out.control_rate(primitive.control_rate);
  for (const motion::Task& task : primitive.tasks) out.tasks().push_back(to_wire(task));
  return out;
}

Result<motion::Primitive> from_wire(const msg::Primitive& message) {
  motion::Primitive out;
  out.name = message.name();
  out.action = message.action();
  out.steps = message.steps();
  out.duration = message.duration();
  out.solver = message.solver();
  out.start = message.start();
  out.max_iterations = message.max_iterations();
  out.tolerance = message.tolerance();
  out.control_rate = message.control_rate();
  PRIMO_TRY(check_count("primitive.tasks", message.tasks().size(), 1000));
  for (const msg::PrimitiveTask& task : message.tasks()) {
    PRIMO_ASSIGN(motion::Task converted, from_wire("primitive.tasks", task));
    out.tasks.push_back(std::move(converted));
  }
  PRIMO_TRY(check_fields("primitive", out));
  return out;
}

msg::PlanRequest to_wire(const motion::PlanRequest& request) {
  msg::PlanRequest out;
  out.scene(to_wire(request.scene));
  if (!motion::needs_map(request.primitive)) out.scene().octree().clear();
  out.action(request.action);
  out.q_start(request.q_start);
  out.primitive(to_wire(request.primitive));
  out.want_gains(request.want_gains);
  out.last(to_wire(request.last));
  if (request.held) {
    msg::HeldObject held;
    held.name(request.held->name);
    held.pose(to_wire(request.held->X_GO));
    out.held().push_back(std::move(held));
  }
  return out;
}

Result<motion::PlanRequest> from_wire(const msg::PlanRequest& message) {
  motion::PlanRequest out;
  PRIMO_ASSIGN(out.scene, from_wire(message.scene()));
  PRIMO_TRY(check_texts("action", message.action()));
  out.action = message.action();
  PRIMO_TRY(check_count("q_start", message.q_start().size(), 1000));
  PRIMO_TRY(check_finite("q_start", message.q_start()));
  out.q_start = message.q_start();
  PRIMO_ASSIGN(out.primitive, from_wire(message.primitive()));
  out.want_gains = message.want_gains();
  PRIMO_ASSIGN(out.last, from_wire("last", message.last()));
  PRIMO_TRY(check_count("held", message.held().size(), 1));
  for (const msg::HeldObject& held : message.held()) {
    PRIMO_TRY(check_text("held.name", held.name()));
    PRIMO_ASSIGN(const Pose X_GO, from_wire("held.pose", held.pose()));
    out.held = motion::HeldObject{held.name(), X_GO};
  }
  return out;
}

msg::Plan to_wire(const motion::Plan& plan) {
  msg::Plan out;
  out.status(static_cast<std::uint8_t>(plan.status));
  out.reason(plan.reason);
  out.joints(plan.trajectory.joints);
  out.dt(plan.trajectory.dt);
  out.q(to_wire(plan.trajectory.q));
  out.feedback(to_wire(plan.gains.K));
  for (const Eigen::VectorXd& k : plan.gains.k) out.feedforward().push_back(to_wire(Eigen::MatrixXd(k)));
  out.iterations(plan.iterations);
  out.rejected(plan.rejected);
  out.evaluations(plan.evaluations);
  out.cost_initial(plan.cost_initial);
  out.cost_final(plan.cost_final);
  out.cost_control(plan.cost_control);
  for (const motion::TaskCost& cost : plan.cost_tasks) {
    msg::NamedNumber entry;
    entry.name(cost.task);
    entry.value(cost.cost);
    out.cost_tasks().push_back(std::move(entry));
  }
  out.gradient_norm(plan.gradient_norm);
  out.lambda(plan.lambda);
  out.start(plan.start);
  return out;
}

Result<motion::Plan> from_wire(const msg::Plan& message) {
  motion::Plan out;
  PRIMO_ASSIGN(out.status, enum_from<motion::PlanStatus>("plan.status", message.status()));
  PRIMO_TRY(check_text("plan.reason", message.reason()));
  out.reason = message.reason();
  PRIMO_TRY(check_texts("plan.joints", message.joints()));
  out.trajectory.joints = message.joints();
  PRIMO_TRY(
      check_finite("plan", std::vector<double>{message.dt(), message.cost_initial(), message.cost_final(),
                                               message.cost_control(), message.gradient_norm(), message.lambda()}));
  out.trajectory.dt = message.dt();
  PRIMO_ASSIGN(out.trajectory.q, from_wire("plan.q", message.q()));
  if (out.trajectory.q.size() > 0 &&
      static_cast<std::size_t>(out.trajectory.q.cols()) != out.trajectory.joints.size()) {
    return malformed("plan.q", "has " + std::to_string(out.trajectory.q.cols()) + " columns for " +
                                   std::to_string(out.trajectory.joints.size()) + " joints");
  }
  PRIMO_ASSIGN(out.gains.K, from_wire("plan.feedback", message.feedback()));
  PRIMO_ASSIGN(const auto feedforward, from_wire("plan.feedforward", message.feedforward()));
  for (const Eigen::MatrixXd& k : feedforward) {
    if (k.cols() != 1) return malformed("plan.feedforward", "must be columns");
    out.gains.k.emplace_back(k.col(0));
  }
  out.iterations = message.iterations();
  out.rejected = message.rejected();
  out.evaluations = message.evaluations();
  out.cost_initial = message.cost_initial();
  out.cost_final = message.cost_final();
  out.cost_control = message.cost_control();
  PRIMO_TRY(check_count("plan.cost_tasks", message.cost_tasks().size()));
  for (const msg::NamedNumber& entry : message.cost_tasks()) {
    PRIMO_TRY(check_text("plan.cost_tasks", entry.name()));
    PRIMO_TRY(check_finite("plan.cost_tasks", entry.value()));
    out.cost_tasks.push_back({entry.name(), entry.value()});
  }
  out.gradient_norm = message.gradient_norm();
  out.lambda = message.lambda();
  PRIMO_TRY(check_text("plan.start", message.start()));
  out.start = message.start();
  return out;
}

}  // namespace primo::wire

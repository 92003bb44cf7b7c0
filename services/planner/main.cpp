// planner: plans motions in perceived scenes.
#include <primo_jobs.h>

#include "motion/planner.h"
#include "service/service.h"
#include "wire/wire.h"

namespace primo {
namespace {

struct PlannerConfig {
  std::string robot;
  template <class V>
  void visit(V&& v) {
    v("robot", robot, {.help = "robot file", .required = true});
  }
};

Status run(const PlannerConfig& config, service::Context& context) {
  PRIMO_ASSIGN(const auto robot, robot::Robot::load(config.robot));
  return context.serve(topics::kPlan, [&](const topics::msg::PlanJob& job) -> Result<topics::msg::PlanReply> {
    PRIMO_ASSIGN(const auto request, wire::from_wire(job.request()));
    topics::msg::PlanReply reply;
    reply.plan(wire::to_wire(motion::plan(robot, request)));
    return reply;
  });
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) { return primo::service::run<primo::PlannerConfig>("planner", argc, argv, primo::run); }

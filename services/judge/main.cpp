// judge: tries planned motions in physics.
#include <primo_jobs.h>

#include "physics/judge.h"
#include "service/service.h"
#include "wire/wire.h"

namespace primo {
namespace {

struct JudgeConfig {
  std::string robot;
  template <class V>
  void visit(V&& v) {
    v("robot", robot, {.help = "robot file", .required = true});
  }
};

Status run(const JudgeConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto robot, robot::Robot::load(config.robot));
  const physics::Judge judge(std::move(robot));
  return context.serve(topics::kJudge, [&](const topics::msg::JudgeJob& job) -> Result<topics::msg::JudgeReply> {
    PRIMO_ASSIGN(const auto request, wire::from_wire(job.request()));
    PRIMO_ASSIGN(const auto verdict, judge.evaluate(request));
    topics::msg::JudgeReply reply;
    reply.verdict(wire::to_wire(verdict));
    return reply;
  });
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) { return primo::service::run<primo::JudgeConfig>("judge", argc, argv, primo::run); }

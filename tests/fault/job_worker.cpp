// A worker for tests that kill, stop and hang it: doubles a number, after as many milliseconds as the request's
// duration says.
//   primo_test_job_worker --name NAME [--domain N]
#include <primo_jobs.h>

#include <chrono>
#include <thread>

#include "service/service.h"

namespace {

using primo_msgs::msg::PlanJob;
using primo_msgs::msg::PlanReply;

struct Config {
  int bias = 0;
  template <class V>
  void visit(V&& v) {
    v("bias", bias, {.help = "added to each answer", .min = -1000, .max = 1000});
  }
};

}  // namespace

int main(int argc, char** argv) {
  return primo::service::run<Config>("planner", argc, argv, [](const Config& config, primo::service::Context& context) {
    return context.serve(primo::topics::kPlan, [&](const PlanJob& job) -> primo::Result<PlanReply> {
      const auto& primitive = job.request().primitive();
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(primitive.duration()));
      PlanReply reply;
      reply.plan().iterations(2 * primitive.steps() + config.bias);
      return reply;
    });
  });
}

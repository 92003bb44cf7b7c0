// What sending a job costs over calling its function: round trips and throughput by size, and the adapters of a plan
// and a judgement. Two or three participants of one process, over the transports that processes use. Wall clock.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bus/job_client.h"
#include "bus/job_server.h"
#include "unit/wire/random_values.h"
#include "wire/wire.h"

namespace {

using namespace primo;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using primo_msgs::msg::PlanJob;
using primo_msgs::msg::PlanReply;

double microseconds(Clock::duration duration) { return std::chrono::duration<double, std::micro>(duration).count(); }

bus::Participant participant(const std::string& name) {
  bus::BusSettings settings;
  settings.domain_override = 100 + static_cast<int>(getpid() % 100);
  return bus::Participant::create(settings, name).value();
}

Result<PlanReply> echo(const PlanJob& job) {
  PlanReply reply;
  reply.plan().q().data(job.request().q_start());
  return reply;
}

struct Worker {
  explicit Worker(const std::string& name, unsigned credits) : member(participant(name)) {
    status = bus::StatusPublisher::create(member, {.role = "planner", .config_hash = {}, .version = {}}).value();
    server.emplace(
        bus::JobServer<PlanJob, PlanReply>::create(member, *status, topics::kPlan, echo, {.credits = credits}).value());
  }
  bus::Participant member;
  std::unique_ptr<bus::StatusPublisher> status;
  std::optional<bus::JobServer<PlanJob, PlanReply>> server;
};

/// `jobs` jobs of that many bytes with at most `window` unanswered: each one's time from submit to completion, and all
/// of them together.
nlohmann::ordered_json measure(std::size_t bytes, unsigned workers, unsigned credits, int jobs) {
  const bus::Participant member = participant("requester");
  const auto watcher = bus::StatusWatcher::create(member).value();
  bus::Mailbox mailbox;
  auto client = bus::JobClient<PlanJob, PlanReply>::create(member, *watcher, topics::kPlan, mailbox).value();
  std::vector<std::unique_ptr<Worker>> crew;
  for (unsigned i = 0; i < workers; ++i)
    crew.push_back(std::make_unique<Worker>("planner" + std::to_string(i), credits));
  while (client.window() < workers * credits) std::this_thread::sleep_for(1ms);

  PlanJob job;
  job.request().q_start(std::vector<double>(bytes / 8));
  std::vector<double> times;
  int submitted = 0, done = 0;
  const auto submit = [&] {
    ++submitted;
    const auto begin = Clock::now();
    (void)client.submit(job, [&, begin](Result<PlanReply>) {
      times.push_back(microseconds(Clock::now() - begin));
      ++done;
    });
  };
  const auto begin = Clock::now();
  while (done < jobs) {
    while (submitted < jobs && submitted - done < static_cast<int>(workers * credits)) submit();
    mailbox.run(100ms);
  }
  const double total = microseconds(Clock::now() - begin);
  std::sort(times.begin(), times.end());
  return {{"bytes", bytes},
          {"workers", workers},
          {"credits", credits},
          {"jobs", jobs},
          {"median_us", times[times.size() / 2]},
          {"p99_us", times[times.size() * 99 / 100]},
          {"jobs_per_second", jobs / (total * 1e-6)}};
}

template <class Function>
double per_call_us(Function function) {
  constexpr int kCalls = 2000;
  const auto begin = Clock::now();
  for (int i = 0; i < kCalls; ++i) function();
  return microseconds(Clock::now() - begin) / kCalls;
}

}  // namespace

int main() {
  nlohmann::ordered_json out;
  PlanJob job;
  job.request().q_start(std::vector<double>(1024));
  out["direct_call_us"] = per_call_us([&] { (void)echo(job).ok(); });
  for (const std::size_t bytes : {std::size_t{256}, std::size_t{8192}, std::size_t{65536}, std::size_t{1} << 20}) {
    const int jobs = bytes > 100000 ? 200 : 2000;
    out["one_at_a_time"].push_back(measure(bytes, 1, 1, jobs));
    out["two_workers_two_credits"].push_back(measure(bytes, 2, 2, jobs));
  }
  // Both of 8 KiB, one job at a time: what DDS adds to a call.
  out["dispatch_overhead_us"] =
      out["one_at_a_time"][1]["median_us"].get<double>() - out["direct_call_us"].get<double>();
  wire::Draw draw(1);
  const auto request = draw.plan_request();
  const auto plan = draw.plan();
  const auto judging = draw.judge_request();
  out["adapters_there_and_back_us"] = {
      {"plan_request", per_call_us([&] { (void)wire::from_wire(wire::to_wire(request)).ok(); })},
      {"plan", per_call_us([&] { (void)wire::from_wire(wire::to_wire(plan)).ok(); })},
      {"judge_request", per_call_us([&] { (void)wire::from_wire(wire::to_wire(judging)).ok(); })}};
  std::puts(out.dump(2).c_str());
}

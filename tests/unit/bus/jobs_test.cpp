#include <primo_jobs.h>

#include <atomic>
#include <map>
#include <set>

#include "bus/job_client.h"
#include "bus/job_server.h"
#include "bus/latched.h"
#include "fixture.h"

namespace primo::bus {
namespace {

using namespace std::chrono_literals;
using primo_msgs::msg::PlanJob;
using primo_msgs::msg::PlanReply;

PlanJob job_of(int number) {
  PlanJob job;
  job.request().primitive().steps(number);
  return job;
}

/// Twice the number, after a while.
struct Worker {
  explicit Worker(const std::string& name, std::chrono::milliseconds duration = 0ms, ServerSettings settings = {})
      : participant(make_participant(name)) {
    status = StatusPublisher::create(participant, {.role = "planner", .config_hash = {}, .version = {}}).value();
    server.emplace(JobServer<PlanJob, PlanReply>::create(
                       participant, *status, topics::kPlan,
                       [this, duration](const PlanJob& job) -> Result<PlanReply> {
                         most = std::max(most.load(), ++inside);
                         std::this_thread::sleep_for(duration);
                         --inside;
                         ++handled;
                         const int number = job.request().primitive().steps();
                         if (number < 0) return Error{Code::data, "steps is negative"};
                         PlanReply reply;
                         reply.plan().iterations(2 * number);
                         return reply;
                       },
                       settings)
                       .value());
  }
  Participant participant;
  std::unique_ptr<StatusPublisher> status;
  std::atomic<int> handled{0}, inside{0}, most{0};
  std::optional<JobServer<PlanJob, PlanReply>> server;
};

struct Requester {
  explicit Requester(const ClientSettings& settings = {}, const std::string& name = "requester")
      : participant(make_participant(name)), watcher(StatusWatcher::create(participant).value()) {
    client.emplace(
        JobClient<PlanJob, PlanReply>::create(participant, *watcher, topics::kPlan, mailbox, settings).value());
  }
  void submit(int number) {
    const auto id = client->submit(job_of(number), [this, number](Result<PlanReply> reply) {
      ++answers[number];
      if (reply.ok()) {
        values[number] = reply->plan().iterations();
        workers.insert(reply->reply().worker());
      } else {
        errors.emplace(number, reply.error());
      }
    });
    ASSERT_TRUE(id.ok()) << id.error().message;
  }
  bool wait_answers(std::size_t count, std::chrono::milliseconds timeout = 20s) {
    const auto until = std::chrono::steady_clock::now() + timeout;
    while (answers.size() < count && std::chrono::steady_clock::now() < until) mailbox.run(20ms);
    return answers.size() >= count;
  }
  Participant participant;
  std::unique_ptr<StatusWatcher> watcher;
  Mailbox mailbox;
  std::optional<JobClient<PlanJob, PlanReply>> client;
  std::map<int, int> answers, values;
  std::map<int, Error> errors;
  std::set<std::string> workers;
};

TEST(Jobs, are_shared_by_two_workers_and_each_is_answered_once) {
  Requester requester;
  Worker one("planner1", 1ms), two("planner2", 1ms);
  ASSERT_TRUE(eventually([&] { return requester.client->window() == 4; }));
  for (int i = 1; i <= 200; ++i) requester.submit(i);
  ASSERT_TRUE(requester.wait_answers(200));
  for (int i = 1; i <= 200; ++i) {
    EXPECT_EQ(requester.answers[i], 1);
    EXPECT_EQ(requester.values[i], 2 * i);
  }
  EXPECT_EQ(requester.workers, (std::set<std::string>{one.participant.id(), two.participant.id()}));
  EXPECT_EQ(one.handled + two.handled, 200);
  EXPECT_GT(one.handled, 20);
  EXPECT_GT(two.handled, 20);
}

TEST(Jobs, wait_for_a_worker_that_starts_later_and_say_so) {
  Requester requester;
  std::mutex mutex;
  std::vector<std::string> said;
  requester.client->on_waiting([&](const std::string& text) {
    const std::lock_guard lock(mutex);
    said.push_back(text);
  });
  requester.submit(3);
  EXPECT_FALSE(requester.mailbox.run(50ms));
  const Worker late("planner1");
  ASSERT_TRUE(requester.wait_answers(1));
  EXPECT_EQ(requester.values[3], 6);
  const std::lock_guard lock(mutex);
  // Between the two it may have seen the worker before its credits.
  ASSERT_GE(said.size(), 2u);
  EXPECT_EQ(said.front(), "a planner (none is up)");
  EXPECT_EQ(said.back(), "");
}

TEST(Jobs, a_requester_keeps_to_a_workers_credits) {
  Requester requester;
  const ServerSettings settings{.credits = 3, .queue = 3};
  Worker worker("planner1", 5ms, settings);
  for (int i = 0; i < 40; ++i) requester.submit(i);
  ASSERT_TRUE(requester.wait_answers(40));
  EXPECT_EQ(requester.client->window(), 3u);
  // With a fourth in flight the worker's queue of 3 would have overflowed at least once, and the job been sent again.
  EXPECT_EQ(requester.client->counters().sent, 40u);
  EXPECT_EQ(worker.most, 1);
}

TEST(Jobs, of_many_requesters_beyond_the_workers_queue_are_handed_back_and_still_done) {
  const ServerSettings settings{.credits = 4, .queue = 2};
  Requester a({}, "a"), b({}, "b");
  const Worker worker("planner1", 2ms, settings);
  for (int i = 0; i < 30; ++i) {
    a.submit(i);
    b.submit(i);
  }
  ASSERT_TRUE(a.wait_answers(30));
  ASSERT_TRUE(b.wait_answers(30));
  EXPECT_TRUE(a.errors.empty());
  EXPECT_TRUE(b.errors.empty());
}

TEST(Jobs, a_workers_error_reaches_the_requester_with_code_and_sentence_and_is_not_tried_again) {
  Requester requester;
  Worker worker("planner1");
  requester.submit(-1);
  ASSERT_TRUE(requester.wait_answers(1));
  ASSERT_TRUE(requester.errors.contains(-1));
  EXPECT_EQ(requester.errors.at(-1).code, Code::data);
  EXPECT_EQ(requester.errors.at(-1).message, worker.participant.id() + ": steps is negative");
  EXPECT_EQ(worker.handled, 1);
  EXPECT_EQ(worker.status->info().jobs_failed, 1u);
}

TEST(Jobs, of_a_draining_worker_go_to_another_and_the_one_in_work_is_finished) {
  Requester requester;
  Worker leaving("planner1", 30ms);
  ASSERT_TRUE(requester.watcher->wait_for("planner", 1, 20s));
  for (int i = 1; i <= 6; ++i) requester.submit(i);
  ASSERT_TRUE(eventually([&] { return leaving.inside == 1; }));
  ASSERT_TRUE(leaving.server->drain(20s));
  EXPECT_EQ(leaving.inside, 0);
  const Worker staying("planner2", 1ms);
  ASSERT_TRUE(requester.wait_answers(6));
  for (int i = 1; i <= 6; ++i) EXPECT_EQ(requester.answers[i], 1);
  EXPECT_TRUE(requester.errors.empty());
  EXPECT_LT(leaving.handled, 6);
  EXPECT_EQ(leaving.handled + staying.handled, 6);
}

TEST(Jobs, survive_a_requesters_end_without_harm_to_the_next_one) {
  Worker worker("planner1", 20ms);
  {
    Requester first({}, "first");
    for (int i = 0; i < 4; ++i) first.submit(i);
    ASSERT_TRUE(eventually([&] {
      first.mailbox.run(1ms);
      return worker.inside == 1;
    }));
  }
  Requester second({}, "second");
  for (int i = 0; i < 10; ++i) second.submit(i);
  ASSERT_TRUE(second.wait_answers(10));
  EXPECT_TRUE(second.errors.empty());
}

TEST(Jobs, a_deadline_sends_a_job_to_another_worker_and_the_late_answer_is_dropped) {
  Requester requester({.deadline = 300ms});
  Worker slow("planner1", 900ms);
  ASSERT_TRUE(requester.watcher->wait_for("planner", 1, 20s));
  requester.submit(1);
  ASSERT_TRUE(eventually([&] { return slow.inside == 1; }));
  Worker quick("planner2");
  ASSERT_TRUE(requester.wait_answers(1));
  EXPECT_EQ(requester.workers, std::set<std::string>{quick.participant.id()});
  ASSERT_TRUE(eventually([&] { return requester.client->counters().dropped == 1; }));
  requester.mailbox.run(50ms);
  EXPECT_EQ(requester.answers[1], 1);
  EXPECT_EQ(requester.client->counters().reissued, 1u);
}

TEST(Jobs, that_no_worker_answers_fail_with_the_workers_named) {
  Requester requester({.deadline = 150ms, .attempts = 2});
  const Worker hung("planner1", 1000ms);
  requester.submit(1);
  ASSERT_TRUE(requester.wait_answers(1));
  ASSERT_TRUE(requester.errors.contains(1));
  const Error& error = requester.errors.at(1);
  EXPECT_EQ(error.code, Code::unavailable);
  EXPECT_NE(error.message.find("in 2 attempts"), std::string::npos) << error.message;
  EXPECT_NE(error.message.find(hung.participant.id() + " didn't answer within 0.15 s"), std::string::npos)
      << error.message;
}

TEST(Jobs, an_exception_in_a_handler_is_an_error_and_the_worker_goes_on) {
  const Participant participant = make_participant("planner1");
  const auto status =
      StatusPublisher::create(participant, {.role = "planner", .config_hash = {}, .version = {}}).value();
  const auto server = JobServer<PlanJob, PlanReply>::create(participant, *status, topics::kPlan,
                                                            [](const PlanJob& job) -> Result<PlanReply> {
                                                              if (job.request().primitive().steps() == 1)
                                                                throw std::runtime_error("no");
                                                              return PlanReply{};
                                                            });
  ASSERT_TRUE(server.ok());
  Requester requester;
  requester.submit(1);
  requester.submit(2);
  ASSERT_TRUE(requester.wait_answers(2));
  EXPECT_EQ(requester.errors.at(1).code, Code::internal);
  EXPECT_FALSE(requester.errors.contains(2));
}

TEST(Jobs, larger_than_what_may_pass_are_refused_at_once) {
  Requester requester;
  const Worker worker("planner1");
  PlanJob job;
  job.request().q_start(std::vector<double>(9u << 20));  // 72 MiB
  bool answered = false;
  ASSERT_TRUE(requester.client
                  ->submit(std::move(job),
                           [&](Result<PlanReply> reply) {
                             answered = true;
                             ASSERT_FALSE(reply.ok());
                             EXPECT_EQ(reply.error().code, Code::data);
                             EXPECT_NE(reply.error().message.find("max_sample_mib"), std::string::npos)
                                 << reply.error().message;
                           })
                  .ok());
  EXPECT_TRUE(eventually([&] {
    requester.mailbox.run(5ms);
    return answered;
  }));
}

TEST(Jobs, of_a_mebibyte_pass_both_ways) {
  const Participant participant = make_participant("planner1");
  const auto status =
      StatusPublisher::create(participant, {.role = "planner", .config_hash = {}, .version = {}}).value();
  const auto server = JobServer<PlanJob, PlanReply>::create(participant, *status, topics::kPlan,
                                                            [](const PlanJob& job) -> Result<PlanReply> {
                                                              PlanReply reply;
                                                              reply.plan().q().data(job.request().q_start());
                                                              return reply;
                                                            });
  Requester requester;
  std::vector<double> numbers(1u << 17);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  int same = 0;
  for (int i = 0; i < 8; ++i) {
    PlanJob job;
    job.request().q_start(numbers);
    ASSERT_TRUE(requester.client
                    ->submit(std::move(job),
                             [&](Result<PlanReply> reply) {
                               ASSERT_TRUE(reply.ok()) << reply.error().message;
                               same += reply->plan().q().data() == numbers;
                             })
                    .ok());
  }
  EXPECT_TRUE(eventually([&] {
    requester.mailbox.run(5ms);
    return same == 8;
  }));
}

}  // namespace
}  // namespace primo::bus

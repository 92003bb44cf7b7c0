#include "bus/dispatch.h"

#include <gtest/gtest.h>

#include <map>

#include "core/random.h"

namespace primo::bus {
namespace {

using namespace std::chrono_literals;

const DispatchTable::Time t0{};

std::map<std::uint64_t, std::string> by_job(const std::vector<DispatchTable::Assignment>& assignments) {
  std::map<std::uint64_t, std::string> map;
  for (const auto& assignment : assignments) map[assignment.job] = assignment.worker;
  return map;
}

TEST(DispatchTable, fills_the_least_loaded_worker_first_and_stops_at_the_credits) {
  DispatchTable table("planner", 10s, 3);
  table.set_worker("a", 2);
  table.set_worker("b", 1);
  for (std::uint64_t job = 1; job <= 5; ++job) table.add(job);
  EXPECT_EQ(by_job(table.assign(t0)), (std::map<std::uint64_t, std::string>{{1, "a"}, {2, "b"}, {3, "a"}}));
  EXPECT_TRUE(table.assign(t0).empty());
  EXPECT_TRUE(table.answered(2, "b"));
  EXPECT_EQ(by_job(table.assign(t0)), (std::map<std::uint64_t, std::string>{{4, "b"}}));
  EXPECT_EQ(table.window(), 3u);
}

TEST(DispatchTable, a_dead_workers_jobs_come_first_again_in_their_order) {
  DispatchTable table("planner", 10s, 3);
  table.set_worker("a", 2);
  for (std::uint64_t job = 1; job <= 4; ++job) table.add(job);
  (void)table.assign(t0);
  table.remove_worker("a");
  table.set_worker("b", 3);
  const auto assignments = table.assign(t0);
  ASSERT_EQ(assignments.size(), 3u);
  EXPECT_EQ(assignments[0].job, 1u);
  EXPECT_EQ(assignments[0].attempt, 2u);
  EXPECT_EQ(assignments[1].job, 2u);
  EXPECT_EQ(assignments[2].job, 3u);
  EXPECT_EQ(assignments[2].attempt, 1u);
}

TEST(DispatchTable, a_passed_deadline_prefers_a_worker_that_has_not_had_the_job) {
  DispatchTable table("planner", 10s, 3);
  table.set_worker("a", 2);
  table.add(1);
  (void)table.assign(t0);
  table.set_worker("b", 1);
  table.expire(t0 + 9s);
  EXPECT_TRUE(table.assign(t0 + 9s).empty());
  EXPECT_EQ(table.next_time(), t0 + 10s);
  table.expire(t0 + 10s);
  EXPECT_EQ(by_job(table.assign(t0 + 10s)), (std::map<std::uint64_t, std::string>{{1, "b"}}));
  EXPECT_TRUE(table.answered(1, "a"));   // late, but first
  EXPECT_FALSE(table.answered(1, "b"));  // doubled
  EXPECT_EQ(table.pending(), 0u);
}

TEST(DispatchTable, an_overdue_worker_gets_its_credit_back_with_its_answer_or_after_twice_the_deadline) {
  DispatchTable table("planner", 10s, 5);
  table.set_worker("a", 1);
  table.add(1);
  table.add(2);
  (void)table.assign(t0);
  table.expire(t0 + 10s);
  EXPECT_TRUE(table.assign(t0 + 10s).empty());
  table.expire(t0 + 20s);
  EXPECT_EQ(by_job(table.assign(t0 + 20s)), (std::map<std::uint64_t, std::string>{{1, "a"}}));
}

TEST(DispatchTable, a_job_that_uses_up_its_attempts_fails_with_what_became_of_each) {
  DispatchTable table("planner", 10s, 2);
  table.set_worker("a", 1);
  table.add(7);
  (void)table.assign(t0);
  table.remove_worker("a");
  table.set_worker("b", 1);
  (void)table.assign(t0);
  table.expire(t0 + 10s);
  const auto failures = table.take_failures();
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_EQ(failures[0].job, 7u);
  EXPECT_EQ(
      failures[0].message,
      "no planner could do job 7 in 2 attempts: a died; b didn't answer within 10 s; see the logs of these workers");
  EXPECT_EQ(table.pending(), 0u);
}

TEST(DispatchTable, a_job_handed_back_is_not_an_attempt_and_leaves_its_worker_in_peace_for_a_moment) {
  DispatchTable table("planner", 10s, 1);
  table.set_worker("a", 1);
  table.add(1);
  for (int i = 0; i < 10; ++i) {
    const auto now = t0 + i * 1s;
    ASSERT_EQ(table.assign(now).size(), 1u);
    table.returned(1, "a", now);
    EXPECT_TRUE(table.assign(now).empty());
    ASSERT_TRUE(table.next_time().has_value());
    EXPECT_LE(*table.next_time(), now + 1s);
  }
  EXPECT_TRUE(table.take_failures().empty());
}

TEST(DispatchTable, under_random_deaths_hangs_and_answers_every_job_ends_exactly_once) {
  for (std::uint64_t run = 0; run < 200; ++run) {
    Random random(run, "dispatch");
    DispatchTable table("judge", 10s, 4);
    std::map<std::uint64_t, int> ended;
    std::vector<DispatchTable::Assignment> sent;  // with doubles
    auto now = t0;
    constexpr std::uint64_t kJobs = 30;
    for (std::uint64_t job = 1; job <= kJobs; ++job) table.add(job);
    for (int step = 0; step < 5000 && ended.size() < kJobs; ++step) {
      now += std::chrono::milliseconds(random.below(3000));
      const std::string worker(1, static_cast<char>('a' + random.below(3)));
      switch (random.below(8)) {
        case 0:
          table.remove_worker(worker);
          break;
        case 1:
        case 2:
          table.set_worker(worker, 2);
          break;
        case 3:
          if (!sent.empty()) {
            const auto& some = sent[random.below(sent.size())];
            table.returned(some.job, some.worker, now);
          }
          break;
        case 4:
        case 5:
          if (!sent.empty()) {
            const auto& some = sent[random.below(sent.size())];
            ended[some.job] += table.answered(some.job, some.worker);
            if (ended[some.job] == 0) ended.erase(some.job);
          }
          break;
        default:
          table.expire(now);
      }
      for (const auto& failure : table.take_failures()) ++ended[failure.job];
      for (const auto& assignment : table.assign(now)) {
        EXPECT_FALSE(ended.contains(assignment.job)) << "sent after its end";
        EXPECT_LE(assignment.attempt, 4u);
        sent.push_back(assignment);
      }
    }
    EXPECT_EQ(ended.size(), kJobs) << "run " << run;
    for (const auto& [job, times] : ended) EXPECT_EQ(times, 1) << "job " << job;
    EXPECT_EQ(table.pending(), 0u);
  }
}

}  // namespace
}  // namespace primo::bus

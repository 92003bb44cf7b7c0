#include "common/pump.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace primo::graph {
namespace {

const Error kFailed{Code::unavailable, "no worker could do it"};

/// Jobs that end when the mailbox runs, in the order in which they were started.
struct Jobs {
  Waiting waiting{[this] { return stop; }, [](const std::string&) {}};
  bus::Mailbox mailbox;
  std::vector<std::size_t> started;
  std::size_t under_way = 0, most = 0, cancelled = 0;
  bool stop = false;

  /// `outcome` of each index; `window` jobs at once.
  Status run(std::size_t n, std::size_t window, const std::function<Status(std::size_t)>& outcome) {
    const auto start = [&](std::size_t index, const Finished& finished) {
      started.push_back(index);
      most = std::max(most, ++under_way);
      mailbox.post([this, &outcome, index, finished] {
        --under_way;
        finished(outcome(index));
        finished(success());  // a doubled answer
      });
    };
    return pump(
        mailbox, waiting, n, [window] { return window; }, start, [this] { ++cancelled; });
  }
};

TEST(Pump, starts_all_jobs_in_order_within_the_window) {
  Jobs jobs;
  EXPECT_TRUE(jobs.run(7, 3, [](std::size_t) { return success(); }).ok());
  EXPECT_EQ(jobs.started, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(jobs.most, 3u);
  EXPECT_EQ(jobs.cancelled, 0u);
  EXPECT_TRUE(Jobs().run(0, 3, [](std::size_t) { return success(); }).ok());
}

TEST(Pump, reports_the_error_of_any_job_also_of_the_last) {
  for (const std::size_t n : {1u, 2u, 5u}) {
    for (std::size_t failing = 0; failing < n; ++failing) {
      Jobs jobs;
      const Status status = jobs.run(n, 2, [&](std::size_t i) { return i == failing ? Status(kFailed) : success(); });
      ASSERT_FALSE(status.ok()) << failing << " of " << n;
      EXPECT_EQ(status.error().message, kFailed.message);
      EXPECT_EQ(jobs.cancelled, 1u);
    }
  }
}

TEST(Pump, reports_the_first_error_when_all_jobs_fail_together) {
  Jobs jobs;
  const Status status = jobs.run(2, 2, [](std::size_t i) { return Status(Error{Code::data, std::to_string(i)}); });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "0");
}

TEST(Pump, ends_when_it_is_to_stop_and_leaves_late_answers_alone) {
  Jobs jobs;
  std::vector<Finished> late;
  jobs.stop = true;
  const Status status = pump(
      jobs.mailbox, jobs.waiting, 3, [] { return std::size_t{2}; },
      [&](std::size_t, const Finished& finished) { late.push_back(finished); }, [&] { ++jobs.cancelled; });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, Code::unavailable);
  EXPECT_EQ(jobs.cancelled, 1u);
  ASSERT_EQ(late.size(), 2u);
  EXPECT_FALSE(late.front().active());
  late.front()(success());
}

}  // namespace
}  // namespace primo::graph

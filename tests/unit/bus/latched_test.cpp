#include "bus/latched.h"

#include <primo_rules.h>
#include <primo_study.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include "bus/status.h"
#include "fixture.h"

namespace primo::bus {
namespace {

using namespace std::chrono_literals;
using primo_msgs::msg::Experience;
using primo_msgs::msg::OptimizeGoal;

/// What a subscription heard, to be asked from the test's thread.
template <class T>
struct Heard {
  std::function<void(T&&)> callback() {
    return [this](T&& sample) {
      const std::lock_guard lock(mutex);
      samples.push_back(std::move(sample));
    };
  }
  std::size_t count() {
    const std::lock_guard lock(mutex);
    return samples.size();
  }
  std::mutex mutex;
  std::vector<T> samples;
};

OptimizeGoal goal_of(const std::string& study, int round) {
  OptimizeGoal goal;
  goal.study(study);
  goal.round(round);
  return goal;
}

TEST(Latched, a_late_joiner_gets_the_last_sample_of_each_key_and_only_that) {
  const Participant a = make_participant("a"), b = make_participant("b");
  auto publisher = Publisher<OptimizeGoal>::create(a, topics::kOptimizeGoal).value();
  for (int round = 0; round < 5; ++round) {
    ASSERT_TRUE(publisher.publish(goal_of("one", round)).ok());
    ASSERT_TRUE(publisher.publish(goal_of("two", 10 + round)).ok());
  }
  Heard<OptimizeGoal> heard;
  const auto subscription = Subscription<OptimizeGoal>::create(b, topics::kOptimizeGoal, heard.callback()).value();
  ASSERT_TRUE(eventually([&] { return heard.count() >= 2; }));
  std::this_thread::sleep_for(50ms);
  ASSERT_EQ(heard.count(), 2u);
  std::map<std::string, int> rounds;
  for (const OptimizeGoal& goal : heard.samples) rounds[goal.study()] = goal.round();
  EXPECT_EQ(rounds, (std::map<std::string, int>{{"one", 4}, {"two", 14}}));
}

TEST(Latched, a_log_gives_a_late_joiner_every_sample_in_order) {
  const Participant a = make_participant("a"), b = make_participant("b");
  auto publisher = Publisher<Experience>::create(a, topics::kExperience).value();
  for (int i = 0; i < 3000; ++i) {
    Experience experience;
    experience.id(std::to_string(i));
    ASSERT_TRUE(publisher.publish(experience).ok());
  }
  Heard<Experience> heard;
  const auto subscription = Subscription<Experience>::create(b, topics::kExperience, heard.callback()).value();
  ASSERT_TRUE(eventually([&] { return heard.count() >= 3000; }, 30s)) << heard.count();
  for (int i = 0; i < 3000; ++i) ASSERT_EQ(heard.samples[static_cast<std::size_t>(i)].id(), std::to_string(i));
}

TEST(Latched, a_key_longer_than_dds_can_hold_is_an_error_and_not_a_crash) {
  const Participant a = make_participant("a");
  auto publisher = Publisher<OptimizeGoal>::create(a, topics::kOptimizeGoal).value();
  const Status status = publisher.publish(goal_of(std::string(5000, 'x'), 1));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, Code::data);
  EXPECT_NE(status.error().message.find("rt/primo/v1/optimize_goal"), std::string::npos);
}

TEST(Qos, a_mismatch_is_reported_on_both_sides_with_topic_policy_and_both_values) {
  const Participant a = make_participant("a"), b = make_participant("b");
  EndpointOptions weak;
  weak.quality = Quality::stream;  // VOLATILE, where the topic's readers want TRANSIENT_LOCAL
  const auto publisher = Publisher<Experience>::create(a, topics::kExperience, weak).value();
  const auto subscription = Subscription<Experience>::create(b, topics::kExperience, [](Experience&&) {}).value();
  for (const Participant* participant : {&a, &b}) {
    ASSERT_TRUE(eventually([&] { return !participant->problems().empty(); })) << participant->name();
    const std::string text = participant->problems().front();
    for (const char* part :
         {"rt/primo/v1/experience", "DURABILITY", "TRANSIENT_LOCAL", "VOLATILE", "offers", "requests"}) {
      EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }
  EXPECT_EQ(publisher.matched(), 0);
}

TEST(Qos, a_lease_longer_than_the_watchers_is_reported) {
  const Participant a = make_participant("a"), b = make_participant("b");
  const auto status =
      StatusPublisher::create(a, {.role = "judge", .config_hash = {}, .version = {}, .lease = 2000ms}).value();
  const auto watcher = StatusWatcher::create(b, 500ms).value();
  ASSERT_TRUE(eventually([&] { return !b.problems().empty(); }));
  const std::string text = b.problems().front();
  for (const char* part : {"worker_status", "LIVELINESS", "MANUAL_BY_TOPIC", "0.5 s", "2 s"}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

TEST(Status, tells_of_join_update_and_death) {
  const Participant a = make_participant("judge1"), b = make_participant("b");
  const auto watcher = StatusWatcher::create(b).value();
  std::mutex mutex;
  std::vector<std::string> events;
  const int subscription = watcher->subscribe([&](WorkerEvent event, const WorkerInfo& worker) {
    const std::lock_guard lock(mutex);
    events.push_back(std::to_string(static_cast<int>(event)) + worker.waiting_for);
  });
  const auto seen = [&](const std::string& what) {
    return eventually([&] {
      const std::lock_guard lock(mutex);
      return std::find(events.begin(), events.end(), what) != events.end();
    });
  };
  {
    const auto status =
        StatusPublisher::create(a, {.role = "judge", .credits = 2, .config_hash = "abc", .version = "1"}).value();
    ASSERT_TRUE(watcher->wait_for("judge", 1, 20s));
    ASSERT_TRUE(seen("0"));
    const WorkerInfo info = watcher->workers("judge").at(0);
    EXPECT_EQ(info.worker, a.id());
    EXPECT_EQ(info.name, "judge1");
    EXPECT_EQ(info.pid, getpid());
    EXPECT_EQ(info.credits, 2u);
    EXPECT_EQ(info.config_hash, "abc");
    status->waiting_for("a camera");
    ASSERT_TRUE(seen("1a camera"));
    EXPECT_EQ(watcher->workers("judge").at(0).state, State::waiting);
  }
  ASSERT_TRUE(seen("2a camera"));
  EXPECT_TRUE(watcher->workers().empty());
  watcher->cancel(subscription);
}

TEST(SharedMemory, that_cannot_be_had_is_said_with_its_size_and_what_to_do) {
  // In a process of its own, which may not write files of more than a mebibyte.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1u << 20, 1u << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    const auto made = Participant::create(test_settings(), "poor");
    const bool right = !made.ok() && made.error().code == Code::unavailable &&
                       made.error().message.find("4 MiB of shared memory in /dev/shm") != std::string::npos;
    _exit(right ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(SharedMemory, is_given_back_when_a_participant_ends) {
  const auto segments = [] {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/map_files")) {
      std::error_code error;
      const auto target = std::filesystem::read_symlink(entry, error).string();
      if (target.find("/dev/shm/fastrtps_") == 0 && target.find("port") == std::string::npos) names.insert(target);
    }
    return names;
  };
  std::set<std::string> during;
  {
    const Participant participant = make_participant("a");
    during = segments();
    EXPECT_FALSE(during.empty());
  }
  for (const std::string& name : during) EXPECT_FALSE(std::filesystem::exists(name)) << name;
}

TEST(Participant, refuses_names_that_could_be_patterns_and_settings_out_of_bounds) {
  for (const char* name : {"", "a b", "*", "planner[1]", "ä"}) {
    const auto made = Participant::create(test_settings(), name);
    ASSERT_FALSE(made.ok()) << name;
    EXPECT_EQ(made.error().code, Code::config);
  }
  BusSettings settings = test_settings();
  settings.segment_mib = 0;
  EXPECT_EQ(Participant::create(settings, "a").error().code, Code::config);
  settings = test_settings();
  settings.peers = {"no.such.host.invalid"};
  const auto made = Participant::create(settings, "a");
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().message.find("no.such.host.invalid"), std::string::npos);
}

TEST(Participant, ids_of_two_incarnations_differ) { EXPECT_NE(make_participant("a").id(), make_participant("a").id()); }

}  // namespace
}  // namespace primo::bus

#include "process.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>

#include "../unit/bus/fixture.h"
#include "bus/shared_memory.h"
#include "bus/status.h"

namespace primo {
namespace {

struct File {
  explicit File(const std::string& text) {
    char name[] = "/tmp/primo_config_XXXXXX";
    close(mkstemp(name));
    path = name;
    std::ofstream(path) << text;
  }
  ~File() { std::remove(path.c_str()); }
  std::string path;
};

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

void expect_refusal(const std::vector<std::string>& arguments, int code, const std::vector<std::string>& said) {
  Process process(arguments);
  EXPECT_EQ(process.wait(), code);
  const std::string output = process.output();
  EXPECT_EQ(lines(output), 1u) << output;
  for (const std::string& part : said) EXPECT_NE(output.find(part), std::string::npos) << output;
}

TEST(ServiceProcess, refuses_a_wrong_configuration_with_one_line_and_78) {
  const File unknown("bais: 1\n"), bounds("bias: 5000\n"), broken("bias: [1\n"),
      nested("service: {bus: {domain: 300}}\n");
  expect_refusal({"--config", unknown.path}, 78, {unknown.path + ":1", "bais", "bias"});
  expect_refusal({"--config", bounds.path}, 78, {bounds.path + ":1", "5000", "1000"});
  expect_refusal({"--config", broken.path}, 78, {broken.path});
  expect_refusal({"--config", nested.path}, 78, {"service.bus.domain", "232"});
  expect_refusal({"--config", "/nonexistent/file.yaml"}, 78, {"/nonexistent/file.yaml"});
  expect_refusal({"--set", "bias=x"}, 78, {"bias"});
  expect_refusal({"--domain", "233"}, 78, {"--domain is 233", "0 to 232"});
  expect_refusal({"--name", "a b"}, 78, {"a b"});
}

TEST(ServiceProcess, refuses_a_wrong_command_line_with_64) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--nonsense"}, {"--domain"}, {"--domain", "x"}, {"stray"}}) {
    Process process(arguments);
    EXPECT_EQ(process.wait(), 64) << process.output();
  }
}

TEST(ServiceProcess, help_teaches_options_and_keys) {
  Process process({"--help"});
  EXPECT_EQ(process.wait(), 0);
  const std::string output = process.output();
  for (const char* part :
       {"--config", "--set", "--domain", "--check-config", "bias", "service.bus.segment_mib", "service.lease_ms"}) {
    EXPECT_NE(output.find(part), std::string::npos) << part;
  }
}

TEST(ServiceProcess, prints_the_effective_configuration_which_it_reads_back) {
  Process first({"--set", "bias=7", "--name", "planner9", "--print-config"});
  ASSERT_EQ(first.wait(), 0);
  const File file(first.output());
  Process second({"--config", file.path, "--print-config"});
  ASSERT_EQ(second.wait(), 0) << second.output();
  EXPECT_EQ(second.output(), first.output());
  EXPECT_NE(first.output().find("bias: 7"), std::string::npos);
  EXPECT_NE(first.output().find("name: planner9"), std::string::npos);
  Process third({"--config", file.path, "--check-config"});
  EXPECT_EQ(third.wait(), 0);
  EXPECT_EQ(third.output(), "");
}

TEST(ServiceProcess, without_shared_memory_says_so_and_ends_with_69) {
  Process process({"--domain", std::to_string(test_domain())}, [] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1u << 20, 1u << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(process.wait(), 69);
  EXPECT_NE(process.output().find("16 MiB of shared memory in /dev/shm"), std::string::npos) << process.output();
}

void wait_until_it_takes_jobs(const Process& process) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (process.output().find("takes jobs") == std::string::npos && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

TEST(ServiceProcess, ends_with_0_at_once_when_told_to_by_either_signal) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Process process = start_worker("planner1");
    wait_until_it_takes_jobs(process);
    process.signal(signal);
    EXPECT_EQ(process.wait(), 0) << process.output();
  }
}

// As Fast DDS does to a port that it takes for dead by mistake.
TEST(ServiceProcess, whose_ports_another_removes_or_replaces_is_reachable_again) {
  for (const bool replaced : {false, true}) {
    Process process = start_worker("orphan");
    wait_until_it_takes_jobs(process);
    // This one knows the worker by its old ports, the later one by the new ones.
    const auto participant = bus::make_participant("before");
    const auto watcher = bus::StatusWatcher::create(participant).value();
    ASSERT_TRUE(watcher->wait_for("planner", 1, std::chrono::seconds(20)));
    auto ports = process.shared_memory();
    for (const std::string& segment : process.segments()) ports.erase(segment);
    ASSERT_GE(ports.size(), 2u);
    for (const std::string& port : ports) {
      std::filesystem::rename(port, port + "_old");
      if (replaced) std::filesystem::copy(port + "_old", port);
      std::filesystem::remove(port + "_old");
    }
    const auto later = bus::make_participant("later");
    const auto later_watcher = bus::StatusWatcher::create(later).value();
    EXPECT_TRUE(later_watcher->wait_for("planner", 1, std::chrono::seconds(20))) << process.output();
    EXPECT_TRUE(bus::eventually([&] { return process.output().find("is opened anew") != std::string::npos; }));
    EXPECT_TRUE(watcher->wait_for("planner", 1, std::chrono::seconds(20)));
    process.signal(SIGTERM);
    EXPECT_EQ(process.wait(), 0) << process.output();
  }
}

TEST(ServiceProcess, stopped_for_seconds_is_reachable_again) {
  Process process = start_worker("stopped");
  wait_until_it_takes_jobs(process);
  process.signal(SIGSTOP);
  {
    // Somebody who talks to it meanwhile, and could take it for dead.
    const auto participant = bus::make_participant("asker");
    const auto watcher = bus::StatusWatcher::create(participant).value();
    std::this_thread::sleep_for(std::chrono::seconds(4));
  }
  process.signal(SIGCONT);
  const auto participant = bus::make_participant("later");
  const auto watcher = bus::StatusWatcher::create(participant).value();
  EXPECT_TRUE(watcher->wait_for("planner", 1, std::chrono::seconds(20)));
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait(), 0);
}

TEST(ServiceProcess, when_killed_leaves_shared_memory_that_is_found_dead_and_removed_while_the_living_keep_theirs) {
  Process living = start_worker("living");
  wait_until_it_takes_jobs(living);
  const auto kept = living.shared_memory();  // before it maps anything of the other
  Process dying = start_worker("dying");
  wait_until_it_takes_jobs(dying);
  auto left = dying.shared_memory();
  for (const std::string& name : kept) left.erase(name);
  EXPECT_GE(kept.size(), 3u);  // a segment and two ports
  ASSERT_GE(left.size(), 1u);
  // As another process leaves a port that it found dead: without the file that is locked by its listener. No
  // participant has this one, whatever its number: theirs begin at 10.
  const std::string port = "fastrtps_port" + std::to_string(7400 + 250 * test_domain() + 5);
  left.insert("/dev/shm/" + port);
  std::ofstream("/dev/shm/" + port) << "dead";
  dying.signal(SIGKILL);
  EXPECT_EQ(dying.wait(), 128 + SIGKILL);
  bus::remove_dead_shared_memory();  // the living one may still write to a port of the dead one, which then stays
  EXPECT_FALSE(std::filesystem::exists("/dev/shm/" + port));
  for (const std::string& name : kept) EXPECT_TRUE(std::filesystem::exists(name)) << name;
  living.signal(SIGTERM);
  EXPECT_EQ(living.wait(), 0);
  bus::remove_dead_shared_memory();
  for (const std::string& name : left) EXPECT_FALSE(std::filesystem::exists(name)) << name;
}

}  // namespace
}  // namespace primo

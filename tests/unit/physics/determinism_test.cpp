// Same request, same bytes: in any process, thread and order, after any other request.
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <numeric>
#include <set>
#include <sstream>
#include <thread>

#include "core/files.h"
#include "core/hash.h"
#include "grasp_fixture.h"
#include "verdict_bytes.h"

extern char** environ;

namespace primo::physics {
namespace {

constexpr std::size_t kRequests = 1000;
constexpr std::size_t kExecuted = 40;  // of them, spread evenly
constexpr const char* kOutput = "PRIMO_DETERMINISM_OUTPUT";

/// Grasps that end in every way there is, as (scene, motion).
std::vector<JudgeRequest> grasps(const robot::Robot& robot) {
  std::vector<JudgeRequest> found;
  for (const double x : {0.78, 0.82}) {
    for (const Eigen::Vector3d& offset :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, 0.01), Eigen::Vector3d(0.012, 0, 0),
          Eigen::Vector3d(0, 0.035, 0), Eigen::Vector3d(0, 0, -0.06), Eigen::Vector3d(-0.035, 0, 0)}) {
      const auto scenario = testing::one_cylinder({x, 0.02});
      if (const auto grasp = testing::hand_made_grasp(robot, scenario, offset))
        found.push_back(testing::request_for(scenario, *grasp));
    }
  }
  return found;
}

/// A thousand different requests: grasps, jiggles, settings, object sizes, both modes.
std::vector<JudgeRequest> requests(const robot::Robot& robot) {
  const auto base = grasps(robot);
  PRIMO_CHECK(base.size() > 6, "the arm reaches most of the grasps");
  std::vector<JudgeRequest> all;
  for (std::size_t i = 0; i < kRequests; ++i) {
    Random random(7, "requests", {i});
    JudgeRequest request = base[i % base.size()];
    request.seed = random.bits();
    request.settings.jiggle_seconds = random.uniform(0.02, 0.2);
    request.settings.jiggle_translation = random.uniform(0.005, 0.04);
    request.scenario.objects[0].mass = random.below(2) == 0 ? 0.3 : 0.5;
    request.scenario.objects[0].radius = random.below(2) == 0 ? 0.0375 : 0.036;
    if (random.below(50) == 0) request.settings.survival_seeds = 1;
    if (i % (kRequests / kExecuted) == 0) request.mode = Mode::execute;
    all.push_back(std::move(request));
  }
  return all;
}

/// The digest of every verdict, in the order of the requests. They are judged in an order drawn from `order`.
std::vector<std::string> digests(const Judge& judge, const std::vector<JudgeRequest>& all, std::uint64_t order,
                                 int threads) {
  std::vector<std::size_t> sequence(all.size());
  std::iota(sequence.begin(), sequence.end(), std::size_t{0});
  Random random(order, "order");
  for (std::size_t i = sequence.size(); i > 1; --i) std::swap(sequence[i - 1], sequence[random.below(i)]);
  std::vector<std::string> found(all.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t k = next++; k < sequence.size(); k = next++) {
      const auto verdict = judge.evaluate(all[sequence[k]]);
      found[sequence[k]] = verdict.ok()
                               ? content_id(testing::bytes(*verdict)) + " " + config::enum_name(verdict->outcome)
                               : "error " + verdict.error().message;
    }
  };
  std::vector<std::jthread> pool;
  for (int t = 0; t < threads; ++t) pool.emplace_back(work);
  pool.clear();  // joins
  return found;
}

/// Runs this program's test `filter` in a process of its own. Its exit code.
int run_self(const std::string& filter) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string(),
                    option = "--gtest_filter=" + filter;
  std::vector<std::string> words = {self, option, "--gtest_also_run_disabled_tests", "--gtest_brief=1"};
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawn(&child, self.c_str(), nullptr, nullptr, argv.data(), environ) != 0) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// The other process of the test below, which starts it.
TEST(Determinism, DISABLED_the_other_process) {
  const char* output = std::getenv(kOutput);
  ASSERT_NE(output, nullptr);
  const auto robot = testing::load_robot();
  const Judge judge(robot);
  const auto all = requests(robot);
  // What came before must not matter: a robot gone wild, other objects, requests that are refused.
  JudgeRequest wild = all[0];
  wild.mode = Mode::execute;
  wild.K.assign(static_cast<std::size_t>(wild.q.rows() - 1),
                Eigen::MatrixXd::Constant(robot.joints(), 2 * robot.joints(), 1e12));
  EXPECT_TRUE(judge.evaluate(wild).ok());
  for (double radius = 0.02; radius < 0.06; radius += 0.004) {
    JudgeRequest other = all[1];
    other.scenario.objects[0].radius = radius;
    EXPECT_TRUE(judge.evaluate(other).ok());
  }
  wild.dt = -1;
  EXPECT_FALSE(judge.evaluate(wild).ok());
  std::string text;
  for (const auto& digest : digests(judge, all, 2, 3)) text += digest + "\n";
  ASSERT_TRUE(write_file(output, text).ok());
}

TEST(Determinism, a_thousand_shuffled_requests_give_the_same_bytes_in_two_processes) {
  const auto output = std::filesystem::path(::testing::TempDir()) / ("primo_digests_" + std::to_string(getpid()));
  ASSERT_EQ(setenv(kOutput, output.c_str(), 1), 0);
  ASSERT_EQ(run_self("Determinism.DISABLED_the_other_process"), 0);
  const auto text = read_file(output);
  std::filesystem::remove(output);
  ASSERT_TRUE(text.ok()) << text.error().message;

  const auto robot = testing::load_robot();
  const Judge judge(robot);
  const auto here = digests(judge, requests(robot), 1, 2);
  std::set<std::string> different(here.begin(), here.end()), outcomes;
  std::istringstream lines(*text);
  std::string there;
  for (std::size_t i = 0; i < here.size(); ++i) {
    ASSERT_TRUE(std::getline(lines, there));
    ASSERT_EQ(here[i], there) << "request " << i;
    outcomes.insert(here[i].substr(here[i].find(' ')));
  }
  // The test sees something only when the requests are different and end in different ways.
  EXPECT_GT(different.size(), 600U);
  EXPECT_GE(outcomes.size(), 4U);
}

}  // namespace
}  // namespace primo::physics

#include "study/local_workers.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/files.h"
#include "study/codec.h"
#include "study/loop.h"
#include "study/report.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = PRIMO_SOURCE_DIR;
const fs::path kRobot = kSource / "configs/robots/schunk_lwa3_sdh2.yaml";

class LocalWorkersTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_local_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    ASSERT_TRUE(write_file(directory / "tiny.yaml",
                           "name: tiny\nrobot: " + kRobot.string() +
                               "\nprimitive: " + (kSource / "configs/primitives/grasp_hand_tuned.yaml").string() +
                               "\ntraining: [" + (kSource / "configs/scenarios/example.yaml").string() +
                               "]\ngoal: [[inhand, X]]\nexperience: {scenarios: 6}\n"
                               "optimizer: {evaluations: 8, population: 4, validation: 1}\nexecuted: 1\n")
                    .ok());
  }
  void TearDown() override { fs::remove_all(directory); }
  std::unique_ptr<LocalWorkers> workers(int threads) {
    LocalOptions options;
    options.threads = threads;
    auto created = LocalWorkers::create(kRobot, options);
    EXPECT_TRUE(created.ok()) << created.error().message;
    return std::move(*created);
  }
  fs::path directory;
};

TEST_F(LocalWorkersTest, a_whole_study_gives_the_same_bytes_on_one_thread_and_on_three) {
  const auto study = load_study(directory / "tiny.yaml");
  ASSERT_TRUE(study.ok()) << study.error().message;
  std::string texts[2];
  for (const int i : {0, 1}) {
    const fs::path run = directory / std::to_string(i);
    const auto result = run_study(*study, run, *workers(i == 0 ? 1 : 3));
    ASSERT_TRUE(result.ok()) << result.error().message;
    texts[i] = read_file(run / "result.json").value();
  }
  EXPECT_EQ(texts[0], texts[1]);

  // Its report is one page with everything in it.
  const auto page = write_report(directory / "0");
  ASSERT_TRUE(page.ok()) << page.error().message;
  const auto html = read_file(*page).value();
  // With the colon, which no encoded picture holds.
  for (const char* scheme : {"http:", "https:"})
    EXPECT_EQ(html.find(scheme), std::string::npos) << "nothing is fetched from elsewhere";
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = html.find("data:image/png;base64,iVBOR", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_GE(pictures, 6u);
  for (const char* word : {"grasp(X)", "inhand(X)", "95 %", "position", "data:image/svg+xml", "What mattered",
                           "fingers.late", "</html>"}) {
    EXPECT_NE(html.find(word), std::string::npos) << word;
  }
}

TEST_F(LocalWorkersTest, a_rollout_is_a_pure_function_of_its_content) {
  const auto study = load_study(directory / "tiny.yaml");
  ASSERT_TRUE(study.ok());
  const auto one = workers(1);
  const auto estimate = observe_scenario(study->parts[0].training[0]);
  ASSERT_TRUE(estimate.ok()) << estimate.error().message;
  Rollout rollout{study->parts[0].training[0], *estimate, study->parts[0].primitive, 7, physics::Mode::final_pose, {}};
  const auto first = one->roll_out(rollout);
  ASSERT_TRUE(first.ok()) << first.error().message;
  rollout.mode = physics::Mode::execute;
  ASSERT_TRUE(one->roll_out(rollout).ok());  // between the two, something else
  rollout.mode = physics::Mode::final_pose;
  const auto second = workers(2)->roll_out(rollout);
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(encode(*first), encode(*second));
  EXPECT_TRUE(first->verdict.before.contains({"cylinder", {"c1"}}));
}

TEST_F(LocalWorkersTest, stop_when_told_to) {
  LocalOptions options;
  int asked = 0;
  options.threads = 1;
  options.stopping = [&] { return ++asked > 3; };
  auto created = LocalWorkers::create(kRobot, options);
  ASSERT_TRUE(created.ok());
  const auto study = load_study(directory / "tiny.yaml");
  ASSERT_TRUE(study.ok());
  const auto result = run_study(*study, directory / "run", **created);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, Code::unavailable);
  EXPECT_FALSE(fs::exists(directory / "run" / "result.json"));
}

TEST_F(LocalWorkersTest, say_which_object_was_not_found) {
  auto study = load_study(directory / "tiny.yaml");
  ASSERT_TRUE(study.ok());
  auto scenario = study->parts[0].training[0];
  // The target stands hidden behind a wall for every camera.
  scenario.cameras = {scene::Camera{}};
  scenario.cameras[0].position = {-3, 0, 0.75};
  scenario.cameras[0].look_at = {-4, 0, 0.75};
  const auto seen = observe_scenario(scenario);
  ASSERT_FALSE(seen.ok());
  EXPECT_NE(seen.error().message.find(scenario.name), std::string::npos) << seen.error().message;
}

TEST_F(LocalWorkersTest, name_a_robot_file_that_cannot_be_read) {
  const auto created = LocalWorkers::create(directory / "none.yaml");
  ASSERT_FALSE(created.ok());
  EXPECT_NE(created.error().message.find("none.yaml"), std::string::npos);
}

}  // namespace
}  // namespace primo::study

#include "study/study.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/files.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = PRIMO_SOURCE_DIR;

class StudyTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_study_" + std::to_string(::getpid()) + "_" +
                                             ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory);
    fs::create_directories(directory);
    text = "name: test\nrobot: " + (kSource / "configs/robots/schunk_lwa3_sdh2.yaml").string() +
           "\nprimitive: " + (kSource / "configs/primitives/grasp_hand_tuned.yaml").string() + "\ntraining: [" +
           (kSource / "configs/scenarios/example.yaml").string() + "]\n";
  }
  void TearDown() override { fs::remove_all(directory); }

  Result<Study> load(const std::string& more, const std::vector<std::string>& overrides = {}) {
    EXPECT_TRUE(write_file(directory / "file.yaml", text + more).ok());
    return load_study(directory / "file.yaml", overrides);
  }
  void expect_refused(const std::string& more, const std::string& word) {
    const auto study = load(more);
    ASSERT_FALSE(study.ok()) << more;
    EXPECT_EQ(study.error().code, Code::config);
    EXPECT_NE(study.error().message.find(word), std::string::npos) << study.error().message;
    EXPECT_NE(study.error().message.find("file.yaml"), std::string::npos) << study.error().message;
  }
  fs::path directory;
  std::string text;
};

TEST_F(StudyTest, is_complete_and_reads_back_to_the_same_study) {
  const auto study = load("optimizer: {evaluations: 77}\n");
  ASSERT_TRUE(study.ok()) << study.error().message;
  EXPECT_EQ(study->parts.at(0).training.at(0).robot_start.size(), 14u) << "the robot's home is filled in";
  EXPECT_EQ(study->parts[0].settings.optimizer.evaluations, 77);
  EXPECT_FALSE(study->parts[0].primitive.tasks.empty());
  const fs::path home = directory / "home";
  const auto adopted = adopt_directory(*study, home);
  ASSERT_TRUE(adopted.ok()) << adopted.error().message;
  EXPECT_EQ(*adopted, Adopted::created);
  const auto back = read_study(home);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(config::dump(*back), config::dump(*study));
  EXPECT_EQ(back->id(), study->id());
}

TEST_F(StudyTest, resumes_in_its_own_directory_and_refuses_anothers_naming_the_key) {
  const auto study = load("");
  ASSERT_TRUE(study.ok());
  const fs::path home = directory / "home";
  ASSERT_TRUE(adopt_directory(*study, home).ok());
  const auto again = adopt_directory(*study, home);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*again, Adopted::resumed);
  auto moved = *study;
  moved.robot = "/elsewhere/robot.yaml";
  EXPECT_TRUE(adopt_directory(moved, home).ok()) << "where the robot's file lies does not matter";

  const auto other = load("", {"optimizer.sigma=0.25"});
  ASSERT_TRUE(other.ok()) << other.error().message;
  EXPECT_NE(other->id(), study->id());
  const auto refused = adopt_directory(*other, home);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, Code::config);
  EXPECT_NE(refused.error().message.find("'parts[0].optimizer.sigma' is 0.3 there and 0.25 now"), std::string::npos)
      << refused.error().message;

  auto displaced = *study;
  displaced.parts[0].training[0].objects[0].position.x() += 0.01;
  const auto scene = adopt_directory(displaced, home);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("parts[0].training[0].objects[0].position[0]"), std::string::npos)
      << scene.error().message;
}

TEST_F(StudyTest, refuses_a_directory_with_a_journal_of_nobody_knows_whom) {
  const auto study = load("");
  ASSERT_TRUE(study.ok());
  ASSERT_TRUE(write_file(directory / "journal.db", "x").ok());
  const auto refused = adopt_directory(*study, directory);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("study.yaml"), std::string::npos);
}

TEST_F(StudyTest, refuses_bad_settings_with_the_file_and_the_key) {
  expect_refused("seed: 5\nexperience: {seed: 5}\n", "experience.seed");
  expect_refused("optimizer: {algorithms: [cma, simplex]}\n", "simplex");
  expect_refused("optimizer: {algorithms: []}\n", "algorithms");
  expect_refused("optimizer: {evaluatons: 5}\n", "evaluations");
  expect_refused("optimizer: {validation: 0}\n", "validation");
  expect_refused("rounds: 0\n", "rounds");
  expect_refused("experience: {displacement: -1}\n", "displacement");
  expect_refused("experience: {scenarios: 3}\nexecuted: 4\n", "executed");
  expect_refused("optimizer: {fitness: {clearance_to: -0.5}}\n", "clearance_from");
  expect_refused("optimizer: {log_rho_min: 9}\n", "log_rho_min");
}

TEST_F(StudyTest, refuses_seeds_that_would_mix_training_and_held_out_scenarios) {
  expect_refused("generalization: {levels: [0.01], seed: 1}\n", "generalization.seed");
  expect_refused("generalization: {levels: [0.01], seed: 1001}\n", "experience.seed");
  EXPECT_TRUE(load("generalization: {seed: 1}\n").ok()) << "without levels the seed is of nothing";
  expect_refused("generalization: {levels: [0.02, 0.01]}\n", "levels");
  expect_refused("generalization: {levels: [0.01], tables: [0.02]}\n", "tables");
  expect_refused("generalization: {levels: [0.01], scenarios: 5, executed: 6}\n", "executed");
}

TEST_F(StudyTest, parts_share_what_stands_beside_them_and_override_it) {
  const auto study = load(
      "seed: 9\noptimizer: {evaluations: 70, sigma: 0.2}\nparts:\n  - {name: one}\n  - {name: two, seed: 8, "
      "optimizer: {sigma: 0.1}}\n  - {name: three}\n");
  ASSERT_TRUE(study.ok()) << study.error().message;
  ASSERT_EQ(study->parts.size(), 3u);
  const auto &one = study->parts[0].settings, &two = study->parts[1].settings;
  EXPECT_EQ(study->parts[0].name, "one");
  EXPECT_EQ(one.seed, 9u);
  EXPECT_EQ(two.seed, 8u);
  EXPECT_EQ(two.optimizer.evaluations, 70);
  EXPECT_EQ(one.optimizer.sigma, 0.2);
  EXPECT_EQ(two.optimizer.sigma, 0.1);
  EXPECT_EQ(study->parts[2].settings.optimizer.sigma, 0.2) << "what one part says, the next does not hear";
  EXPECT_EQ(study->parts[2].settings.seed, 9u);
  expect_refused("parts: []\n", "parts");
  expect_refused("parts: [{name: one}, {name: one}]\n", "'one'");
  expect_refused("parts: [{name: one, sed: 3}]\n", "seed");
  expect_refused("parts: [one]\n", "parts");
}

TEST_F(StudyTest, overrides_reach_all_parts_or_the_one_they_name) {
  const std::string parts = "parts: [{name: one, optimizer: {evaluations: 5}}, {name: two}]\n";
  const auto study = load(parts, {"optimizer.evaluations=33", "two.optimizer.evaluations=44", "name=other"});
  ASSERT_TRUE(study.ok()) << study.error().message;
  EXPECT_EQ(study->name, "other");
  EXPECT_EQ(study->parts[0].settings.optimizer.evaluations, 33);
  EXPECT_EQ(study->parts[1].settings.optimizer.evaluations, 44);
  for (const char* wrong : {"parts=3", "three.optimizer.evaluations=1", "optimizer.evaluatons=1", "optimizer=3"}) {
    EXPECT_FALSE(load(parts, {wrong}).ok()) << wrong;
  }
}

TEST_F(StudyTest, includes_other_files_whose_paths_are_theirs) {
  fs::create_directories(directory / "base");
  fs::copy_file(kSource / "configs/primitives/grasp_hand_tuned.yaml", directory / "base/p.yaml");
  ASSERT_TRUE(write_file(directory / "base/all.yaml", text + "seed: 3\nrounds: 4\nprimitive: p.yaml\n").ok());
  text.replace(text.find("primitive:"), text.find("training:") - text.find("primitive:"), "");
  ASSERT_TRUE(write_file(directory / "base/rounds.yaml", "rounds: 5\n").ok());
  // A key that stands twice is a mistake of the file's, so the includes come from files without it.
  ASSERT_TRUE(write_file(directory / "base/some.yaml", "include: rounds.yaml\nseed: 3\nprimitive: p.yaml\n").ok());
  const auto study = load("include: base/some.yaml\nseed: 4\n");
  ASSERT_TRUE(study.ok()) << study.error().message;
  EXPECT_EQ(study->parts[0].settings.seed, 4u) << "the including file has the last word";
  EXPECT_EQ(study->parts[0].settings.rounds, 5);
  EXPECT_EQ(study->parts[0].primitive.action, "grasp");
  expect_refused("include: file.yaml\n", "include");
  expect_refused("include: nowhere.yaml\n", "nowhere.yaml");
  expect_refused("include: [base/some.yaml, {}]\n", "include");
}

TEST_F(StudyTest, an_alias_of_yaml_may_name_files_in_several_places) {
  fs::copy_file(kSource / "configs/scenarios/example.yaml", directory / "scene.yaml");
  const auto study = load("parts: [{name: one, training: &scenes [scene.yaml]}, {name: two, training: *scenes}]\n");
  ASSERT_TRUE(study.ok()) << study.error().message;
  EXPECT_EQ(study->parts[0].training[0].name, study->parts[1].training[0].name);
}

TEST_F(StudyTest, differences_are_told_key_by_key_with_both_values) {
  const auto one = load("seed: 3\n"), other = load("seed: 4\nparts: [{name: a}, {name: b}]\n");
  ASSERT_TRUE(one.ok() && other.ok());
  const auto none = differences(*one, *one);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none->empty());
  const auto found = differences(*one, *other);
  ASSERT_TRUE(found.ok());
  const auto has = [&](const std::string& key, const std::string& first, const std::string& second) {
    return std::any_of(found->begin(), found->end(),
                       [&](const Distinct& d) { return d.key == key && d.first == first && d.second == second; });
  };
  EXPECT_TRUE(has("parts[0].seed", "3", "4"));
  EXPECT_TRUE(has("parts[0].name", "grasp", "a"));
  EXPECT_TRUE(has("parts[1].name", "(nothing)", "b"));
}

TEST_F(StudyTest, may_search_the_entries_of_another_primitive_of_the_same_action) {
  EXPECT_FALSE(load("")->parts[0].structure);
  const auto study = load("structure: " + (kSource / "configs/primitives/grasp_robust.yaml").string() + "\n");
  ASSERT_TRUE(study.ok()) << study.error().message;
  ASSERT_TRUE(study->parts[0].structure);
  EXPECT_EQ(study->parts[0].structure->name, "grasp_robust");
  EXPECT_EQ(study->parts[0].primitive.name, "grasp_hand_tuned") << "P itself stays what it is";
  ASSERT_TRUE(adopt_directory(*study, directory / "home").ok());
  EXPECT_EQ(config::dump(read_study(directory / "home").value()), config::dump(*study));
  EXPECT_NE(study->id(), load("")->id());
  expect_refused("structure: " + (kSource / "configs/primitives/place_reference.yaml").string() + "\n", "structure");
  const auto missing = load("structure: nowhere.yaml\n");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("nowhere.yaml"), std::string::npos) << missing.error().message;
}

TEST_F(StudyTest, says_which_file_is_missing) {
  text.replace(text.find("example.yaml"), 12, "nowhere.yaml");
  const auto study = load("");
  ASSERT_FALSE(study.ok());
  EXPECT_NE(study.error().message.find("nowhere.yaml"), std::string::npos) << study.error().message;
}

TEST_F(StudyTest, refuses_a_scenario_of_another_action) {
  auto study = load("");
  ASSERT_TRUE(study.ok());
  study->parts[0].training[0].action[0] = "place";
  const auto status = study->validate();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("place"), std::string::npos);
}

}  // namespace
}  // namespace primo::study

#include "optim/checkpoint.h"

#include <unistd.h>

#include <filesystem>

#include "core/files.h"
#include "core/random.h"
#include "functions.h"

namespace primo::optim {
namespace {

namespace fs = std::filesystem;
using test::box;
using test::make;

class CheckpointTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    directory = fs::temp_directory_path() / ("primo_checkpoint_" + std::to_string(::getpid()));
    fs::remove_all(directory);
    fs::create_directories(directory);
    file = directory / "state.json";
    settings = {.name = GetParam(), .evaluations = 400, .seed = 0xfedcba9876543210ULL};
  }
  void TearDown() override { fs::remove_all(directory); }
  std::string read() const { return read_file(file).value(); }

  fs::path directory, file;
  OptimizerSettings settings;
  const Bounds bounds = box(4, -2, 6);
};
INSTANTIATE_TEST_SUITE_P(Table, CheckpointTest, testing::ValuesIn(optimizer_names()));

TEST_P(CheckpointTest, an_optimizer_goes_on_from_its_file_bit_for_bit) {
  const auto cost = test::function("rosenbrock");
  const auto straight = make(settings, bounds);
  while (!straight->done()) {
    test::generation(*straight, cost);
    // Loaded, one generation, saved: as if the process had been killed after each.
    auto loaded = load_checkpoint(file, settings, bounds, "rosenbrock");
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    test::generation(**loaded, cost);
    ASSERT_EQ((*loaded)->state(), straight->state());
    const auto saved = save_checkpoint(file, **loaded, "rosenbrock");
    ASSERT_TRUE(saved.ok()) << saved.error().message;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 1) << "no temporary file is left";
}

TEST_P(CheckpointTest, of_another_problem_is_refused_and_left_as_it_is) {
  const auto optimizer = make(settings, bounds);
  test::generation(*optimizer, test::function("sphere"));
  ASSERT_TRUE(save_checkpoint(file, *optimizer, "sphere").ok());
  const std::string before = read();
  const auto refused = [&](const OptimizerSettings& other, const Bounds& box, const std::string& problem,
                           const std::string& word) {
    const auto loaded = load_checkpoint(file, other, box, problem);
    ASSERT_FALSE(loaded.ok()) << word;
    EXPECT_EQ(loaded.error().code, Code::config);
    EXPECT_NE(loaded.error().message.find("another problem"), std::string::npos) << loaded.error().message;
    EXPECT_NE(loaded.error().message.find(word), std::string::npos) << loaded.error().message;
    EXPECT_NE(loaded.error().message.find(file.string()), std::string::npos) << loaded.error().message;
    EXPECT_FALSE(save_checkpoint(file, *make(other, box), problem).ok());
    EXPECT_EQ(read(), before);
  };
  refused(settings, bounds, "ellipsoid", "'problem' is \"sphere\", here it is \"ellipsoid\"");
  auto other = settings;
  other.seed = 2;
  refused(other, bounds, "sphere", "'seed' is 18364758544493064720, here it is 2");
  other = settings;
  other.population = 13;
  refused(other, bounds, "sphere", "'population'");
  refused(settings, box(5, -2, 6), "sphere", "'lower'");
  refused(settings, box(4, -2, 7), "sphere", "'upper'");
  // Another budget is no other problem.
  other = settings;
  other.evaluations = 1000;
  EXPECT_TRUE(load_checkpoint(file, other, bounds, "sphere").ok());
}

TEST_P(CheckpointTest, that_is_further_ahead_is_not_replaced) {
  const auto ahead = make(settings, bounds), behind = make(settings, bounds);
  for (int g = 0; g < 3; ++g) test::generation(*ahead, test::function("sphere"));
  ASSERT_TRUE(save_checkpoint(file, *ahead, "sphere").ok());
  test::generation(*behind, test::function("sphere"));
  const auto status = save_checkpoint(file, *behind, "sphere");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("further ahead"), std::string::npos) << status.error().message;
  EXPECT_EQ((*load_checkpoint(file, settings, bounds, "sphere"))->evaluations(), ahead->evaluations());
}

TEST_P(CheckpointTest, cut_anywhere_or_with_a_byte_changed_is_refused_and_left_as_it_is) {
  const auto optimizer = make(settings, bounds);
  for (int g = 0; g < 3; ++g) test::generation(*optimizer, test::function("sphere"));
  const std::string good = checkpoint_text(*optimizer, "sphere");
  ASSERT_TRUE(optimizer_from_text(good, settings, bounds, "sphere").ok());
  for (std::size_t size = 0; size + 2 < good.size(); size += 7) {
    ASSERT_FALSE(optimizer_from_text(good.substr(0, size), settings, bounds, "sphere").ok()) << size;
  }
  Random random(2, "bytes");
  int same = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = good;
    text[random.below(text.size())] = static_cast<char>(random.below(256));
    const auto read = optimizer_from_text(text, settings, bounds, "sphere");
    // White space may change, and a last digit that no double holds; nothing that counts may.
    if (!read.ok()) continue;
    ++same;
    ASSERT_EQ((*read)->state(), optimizer->state());
  }
  EXPECT_LT(same, 200);
  ASSERT_TRUE(write_file(file, good.substr(0, good.size() / 2)).ok());
  const auto loaded = load_checkpoint(file, settings, bounds, "sphere");
  ASSERT_FALSE(loaded.ok());
  EXPECT_EQ(loaded.error().code, Code::data);
  EXPECT_NE(loaded.error().message.find("half a file"), std::string::npos) << loaded.error().message;
  EXPECT_FALSE(save_checkpoint(file, *optimizer, "sphere").ok());
  EXPECT_EQ(read(), good.substr(0, good.size() / 2));
}

TEST_P(CheckpointTest, is_not_taken_from_texts_made_to_harm) {
  for (const std::string text :
       {std::string(), std::string("null"), std::string("[]"), std::string("{}"), std::string(2000000, '['),
        std::string("{\"format\":1}"), std::string("\0\xff\xfe", 3)}) {
    const auto read = optimizer_from_text(text, settings, bounds, "sphere");
    ASSERT_FALSE(read.ok());
    EXPECT_FALSE(read.error().message.empty());
  }
}

TEST_P(CheckpointTest, is_small_and_has_a_line_for_each_quantity) {
  const auto optimizer = make(settings, bounds);
  test::run(*optimizer, test::function("rosenbrock"));
  const std::string text = checkpoint_text(*optimizer, "rosenbrock");
  EXPECT_LT(text.size(), 20000u);
  for (const auto& [name, values] : optimizer->state()) {
    EXPECT_NE(text.find("\n    \"" + name + "\": ["), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace primo::optim

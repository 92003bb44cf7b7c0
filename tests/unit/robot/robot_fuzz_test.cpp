// Truncated and mutated robot files and models: read or refused, never a crash.
#include <gtest/gtest.h>

#include "core/files.h"
#include "core/random.h"
#include "robot_text.h"

namespace primo::robot {
namespace {

const std::vector<std::string> kWords = {
    "nan",   "inf",     "-1",    "1e999", "0",          "<",    ">",    "/>",          "\"",  "&lt;",
    "<body", "</body>", "joint", "name=", "range=",     "-0.0", "true", "[",           "]",   "{",
    "}",     "1e-320",  "\n",    ":",     "9999999999", "box",  "mesh", "class=\"x\"", "<!--"};

std::string mutate(std::string text, Random& random) {
  const auto changes = 1 + random.below(4);
  for (std::uint64_t i = 0; i < changes && !text.empty(); ++i) {
    const auto at = random.below(text.size());
    switch (random.below(5)) {
      case 0:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 1:
        text.erase(at, 1 + random.below(30));
        break;
      case 2:
        text.insert(at, text.substr(random.below(text.size()), random.below(80)));
        break;
      case 3:
        text.resize(at);
        break;
      default:
        text.replace(at, random.below(6), kWords[random.below(kWords.size())]);
    }
  }
  return text;
}

class RobotFuzz : public testing::TestWithParam<const char*> {};

TEST_P(RobotFuzz, MutatedFilesAreReadOrRefusedInWords) {
  const std::string name = GetParam();
  const auto folder = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots";
  const std::string yaml = read_file(folder / (name + ".yaml")).value(),
                    xml = read_file(folder / (name + ".xml")).value();
  const RobotFolder copy;
  int accepted = 0;
  constexpr std::uint64_t kTrials = 600;
  for (std::uint64_t i = 0; i < kTrials; ++i) {
    Random random(1, "robot fuzz " + name, {i});
    copy.put("robot.yaml", i % 2 ? mutate(yaml, random) : yaml);
    copy.put(name + ".xml", i % 2 ? xml : mutate(xml, random));
    const auto robot = copy.load();
    accepted += robot.ok();
    if (!robot.ok()) {
      EXPECT_GT(robot.error().message.size(), 10U);
    } else {
      EXPECT_TRUE(robot->forward(robot->home()).X_WB.back().matrix().allFinite());
    }
  }
  EXPECT_GT(accepted, 10);
  EXPECT_LT(accepted, static_cast<int>(kTrials) - 100);
}

INSTANTIATE_TEST_SUITE_P(Both, RobotFuzz, testing::Values("schunk_lwa3_sdh2", "column7_pg130"));

}  // namespace
}  // namespace primo::robot

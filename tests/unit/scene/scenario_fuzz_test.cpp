// Runs the fuzz target on mutations of a good file, so that it is exercised with any compiler.
#include <gtest/gtest.h>

#include "../../fuzz/fuzz_scenario.cpp"
#include "core/files.h"
#include "core/random.h"

namespace primo::scene {
namespace {

const std::vector<std::string> kWords = {"nan",  ".inf", "-1", "1e999",   "[",    "]",      "{",  "}",    ":",
                                         "- ",   "&a",   "*a", "!!int",   "name", "\t",     "\n", "~",    "0x10",
                                         "true", "''",   "\"", "objects", "rpy",  "1e-320", "# ", "<<: ", "?"};

std::string mutate(std::string text, Random& random) {
  const auto changes = 1 + random.below(6);
  for (std::uint64_t i = 0; i < changes && !text.empty(); ++i) {
    const auto at = random.below(text.size());
    switch (random.below(5)) {
      case 0:
        text[at] = static_cast<char>(random.below(256));
        break;
      case 1:
        text.erase(at, 1 + random.below(20));
        break;
      case 2:
        text.insert(at, kWords[random.below(kWords.size())]);
        break;
      case 3:
        text.insert(at, text.substr(random.below(text.size()), random.below(60)));
        break;
      default:
        text.replace(at, random.below(5), kWords[random.below(kWords.size())]);
    }
  }
  return text;
}

TEST(ScenarioFuzz, mutated_files_are_read_or_refused_and_what_is_read_survives_a_dump) {
  const auto example = read_file(std::string(PRIMO_SOURCE_DIR) + "/configs/scenarios/example.yaml");
  ASSERT_TRUE(example.ok());
  int accepted = 0;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    Random random(1, "scenario fuzz", {i});
    const std::string text = mutate(*example, random);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    accepted += read_scenario_text(text, "f").ok();
  }
  EXPECT_GT(accepted, 30);
  EXPECT_LT(accepted, 2000);
}

}  // namespace
}  // namespace primo::scene

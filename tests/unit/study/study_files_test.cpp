#include <gtest/gtest.h>

#include <filesystem>

#include "study/study.h"

namespace primo::study {
namespace {

TEST(StudyFiles, of_the_project_can_all_be_loaded) {
  int studies = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PRIMO_SOURCE_DIR "/configs/studies")) {
    if (entry.path().extension() != ".yaml") continue;
    const auto study = load_study(entry.path());
    ASSERT_TRUE(study.ok()) << study.error().message;
    EXPECT_EQ(study->name, entry.path().stem());
    ++studies;
  }
  EXPECT_GE(studies, 2);
}

}  // namespace
}  // namespace primo::study

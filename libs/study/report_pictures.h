// The report's rendered pictures. Private to libs/study.
#pragma once

#include <filesystem>
#include <string>

#include "study/result.h"
#include "study/study.h"

namespace primo::study {

/// PNG bytes of one training scenario and of the grasps planned in it, and what the judge says of them.
struct Pictures {
  std::string scenario;  ///< its name
  std::string scene;
  std::string motion_before, motion_after;
  std::string hand_before, hand_after;
  std::string verdict_before, verdict_after;
};

/// Plans again with P and with P* in the training scenario that shows the difference best: the first in which only P*
/// succeeds, else the first. Files are written to `folder` as well.
Result<Pictures> draw_pictures(const Study& study, const StudyResult& result, const std::filesystem::path& folder);

}  // namespace primo::study

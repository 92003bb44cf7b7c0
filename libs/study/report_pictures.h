// The report's rendered pictures. Private to libs/study.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/journal.h"
#include "study/local_workers.h"
#include "study/result.h"
#include "study/study.h"

namespace primo::study {

/// A typical failure: the final pose of a plan that fails, with the fingers closed.
struct FailurePicture {
  bool optimized = false;   ///< of P*, else of P
  std::string cause;        ///< Cause by its name
  int count = 0, of = 0;    ///< failures of this cause among the scenarios of the level
  double displacement = 0;  ///< m, of the level
  std::string png, verdict;
};

/// PNG bytes of one training scenario and of the motions planned in it, and what the judge says of them.
struct PartPictures {
  std::string scenario;  ///< its name
  std::string scene;
  std::string motion_before, motion_after, motion_both;
  std::string hand_before, hand_after;
  std::string verdict_before, verdict_after;
  std::vector<FailurePicture> failures;
};

/// Plans again with P and with P* in the training scenario that shows the difference best: the first in which only P*
/// succeeds, else the first; and in held-out scenarios with typical failures. Files are written to `folder` as well,
/// their names begin with the part's.
Result<PartPictures> draw_pictures(LocalWorkers& workers, const Part& part, const PartResult& result, Journal& journal,
                                   const std::filesystem::path& folder);

}  // namespace primo::study

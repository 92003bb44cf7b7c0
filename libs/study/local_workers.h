// All of a study's work in this process, on a few threads. What the services do over DDS, with the same functions.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "study/backend.h"
#include "study/optimization.h"

namespace primo::study {

class LocalWorkers : public Workers {
 public:
  struct Options {
    int threads = 0;                 ///< 0: as many as there are processors
    std::function<bool()> stopping;  ///< asked between rollouts; true ends the work with Code::unavailable
    OnProgress on_progress;          ///< of the optimization
  };
  static Result<std::unique_ptr<LocalWorkers>> create(const std::filesystem::path& robot_file, Options options);
  static Result<std::unique_ptr<LocalWorkers>> create(const std::filesystem::path& robot_file) {
    return create(robot_file, Options{});
  }

  virtual Result<RolloutResult> roll_out(const Rollout& rollout) const = 0;
};

}  // namespace primo::study

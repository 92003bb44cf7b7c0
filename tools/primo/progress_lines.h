// One line for each stage of a study: rewritten in place on a terminal, printed once at the stage's end elsewhere.
#pragma once

#include <chrono>
#include <string>

#include "core/statistics.h"

namespace primo::tool {

/// A stage as it stands.
struct StageState {
  std::string part;  ///< of the study
  int round = 0;
  std::string stage;
  std::string subject;  ///< algorithm or primitive
  int done = 0, total = 0;
  double rate = 0;  ///< a second
  double seconds_left = 0;
  bool searching = false;  ///< the four below mean something
  double best_gamma = 0, mean_gamma = 0;
  double sigma = 0, condition = 0;  ///< of the search's distribution; sigma 0 where there is none
  Rate success;
  bool finished = false;
};

class ProgressLines {
 public:
  ProgressLines();
  void show(const StageState& state);
  /// A sentence on a line of its own.
  void say(const std::string& text);
  /// Ends a line that stands open.
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool open_ = false;
  std::string stage_;  // that is being shown
  std::string last_;   // the stage's last text
  Clock::time_point begin_{};
};

}  // namespace primo::tool

// Publishes where a study or an optimization stands, with its rate and the time left.
#pragma once

#include <primo_study.h>

#include <chrono>
#include <deque>
#include <string>

#include "bus/latched.h"
#include "study/optimization.h"

namespace primo::graph {

/// One thread at a time. Samples of one stage that follow each other too fast are left out, but not the last of a stage
/// and not the generations of an optimization.
class ProgressPublisher {
 public:
  /// `source`: conductor or optimizer.
  static Result<ProgressPublisher> create(const bus::Participant& participant, const std::string& source);
  Status publish(const study::Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;
  struct Point {
    Clock::time_point time;
    int done;
  };
  ProgressPublisher(std::string source, bus::Publisher<primo_msgs::msg::Progress> publisher)
      : source_(std::move(source)), publisher_(std::move(publisher)) {}
  double rate(const study::Progress& progress, Clock::time_point now);

  std::string source_;
  bus::Publisher<primo_msgs::msg::Progress> publisher_;
  std::string stage_;  // of the last sample: part, round, stage, algorithm
  Clock::time_point published_{};
  std::deque<Point> points_;  // of this stage, the last seconds
};

}  // namespace primo::graph

#include "common/progress.h"

namespace primo::graph {
namespace {
constexpr std::chrono::milliseconds kPause{150};  // between samples of one stage
constexpr std::chrono::seconds kWindow{10};       // over which the rate is taken
}  // namespace

Result<ProgressPublisher> ProgressPublisher::create(const bus::Participant& participant, const std::string& source) {
  PRIMO_ASSIGN(auto publisher, bus::Publisher<primo_msgs::msg::Progress>::create(participant, topics::kProgress));
  return ProgressPublisher(source, std::move(publisher));
}

double ProgressPublisher::rate(const study::Progress& progress, Clock::time_point now) {
  points_.push_back({now, progress.done});
  while (points_.size() > 2 && now - points_.front().time > kWindow) points_.pop_front();
  const double seconds = std::chrono::duration<double>(now - points_.front().time).count();
  return seconds > 0.05 ? (progress.done - points_.front().done) / seconds : 0.0;
}

Status ProgressPublisher::publish(const study::Progress& progress) {
  const auto now = Clock::now();
  const std::string stage =
      progress.part + " " + std::to_string(progress.round) + " " + progress.stage + " " + progress.algorithm;
  const bool same = stage == stage_;
  // A stage may come again, e.g. with other scenarios.
  if (!same || (!points_.empty() && progress.done < points_.back().done)) points_.clear();
  stage_ = stage;
  const double per_second = rate(progress, now);
  const bool last = progress.finished || progress.done >= progress.total;
  // Generations are few enough to be told one by one.
  const bool generation = progress.stage == "optimize";
  if (same && !last && !generation && now - published_ < kPause) return success();
  published_ = now;

  primo_msgs::msg::Progress message;
  message.source(source_);
  message.study(progress.study);
  message.part(progress.part);
  message.round(progress.round);
  message.stage(progress.stage);
  message.algorithm(progress.algorithm);
  message.done(progress.done);
  message.total(progress.total);
  message.rate(per_second);
  message.seconds_left(per_second > 0 ? (progress.total - progress.done) / per_second : 0.0);
  message.best_gamma(progress.best_gamma);
  message.mean_gamma(progress.mean_gamma);
  message.sigma(progress.sigma);
  message.condition(progress.condition);
  message.success().successes(progress.success.successes);
  message.success().trials(progress.success.trials);
  message.finished(progress.finished);
  message.text(progress.text);
  return publisher_.publish(message);
}

}  // namespace primo::graph

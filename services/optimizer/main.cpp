// optimizer: optimizes a primitive's precisions for the goal that the conductor has latched. Its state is the study's
// journal: started again it finds the goal still latched and goes on from there.
#include <primo_study.h>

#include <condition_variable>
#include <mutex>
#include <optional>

#include "bus/latched.h"
#include "common/dds_workers.h"
#include "common/progress.h"
#include "service/service.h"
#include "study/loop.h"
#include "wire/wire.h"

namespace primo {
namespace {

struct OptimizerConfig {
  double deadline = 20;
  int attempts = 10;
  template <class V>
  void visit(V&& v) {
    v("deadline", deadline,
      {.help = "of a plan or a verdict, before it is asked for elsewhere", .unit = "s", .min = 0.1, .max = 3600});
    v("attempts", attempts, {.help = "of a plan or a verdict, before the optimization fails", .min = 1, .max = 1000});
  }
};

/// The newest goal. An empty request withdraws it.
class Desk {
 public:
  void put(topics::msg::OptimizeGoal&& goal) {
    {
      const std::lock_guard lock(mutex_);
      goal_ = std::move(goal);
      ++changes_;
    }
    changed_.notify_all();
  }
  /// Waits for a goal that differs from the one of `change`; empty when none came in time or it was withdrawn.
  std::optional<topics::msg::OptimizeGoal> take(std::uint64_t& change, std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, timeout, [&] { return changes_ != change; })) return std::nullopt;
    change = changes_;
    if (goal_.request().empty()) return std::nullopt;
    return goal_;
  }
  /// Whether the goal in hand is no longer wanted: it was withdrawn or replaced by one with another content. `change`:
  /// of the goal that was compared last.
  bool replaced(const topics::msg::OptimizeGoal& in_hand, std::uint64_t& change) const {
    const std::lock_guard lock(mutex_);
    if (changes_ == change) return false;
    if (goal_.request().empty() || !same_content(goal_, in_hand)) return true;
    change = changes_;
    return false;
  }
  /// Who asked last for the goal in hand: a conductor that starts again asks once more.
  std::string request(std::uint64_t& change) const {
    const std::lock_guard lock(mutex_);
    change = changes_;
    return goal_.request();
  }

 private:
  static bool same_content(topics::msg::OptimizeGoal a, const topics::msg::OptimizeGoal& b) {
    a.request(b.request());
    return a == b;
  }
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  topics::msg::OptimizeGoal goal_;
  std::uint64_t changes_ = 0;
};

Status run(const OptimizerConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto publisher,
               bus::Publisher<topics::msg::OptimizedPrimitive>::create(context.participant(), topics::kPrimitive));
  PRIMO_ASSIGN(auto progress, graph::ProgressPublisher::create(context.participant(), "optimizer"));
  Desk desk;
  const auto on_goal = [&](topics::msg::OptimizeGoal&& goal) { desk.put(std::move(goal)); };
  PRIMO_ASSIGN(const auto subscription, bus::Subscription<topics::msg::OptimizeGoal>::create(
                                            context.participant(), topics::kOptimizeGoal, on_goal));

  topics::msg::OptimizeGoal in_hand;
  bus::ClientSettings client;
  client.deadline = std::chrono::milliseconds(static_cast<int>(config.deadline * 1000));
  client.attempts = config.attempts;
  std::uint64_t change = 0;
  const graph::Waiting waiting{[&] { return context.stopping() || desk.replaced(in_hand, change); },
                               [&](const std::string& text) { context.waiting_for(text); }};

  context.status().set_state(bus::State::idle);
  while (!context.stopping()) {
    const auto taken = desk.take(change, std::chrono::milliseconds(200));
    if (!taken) continue;
    in_hand = *taken;
    context.log().info("optimizing {} for study {}, round {}", in_hand.primitive().action(), in_hand.study(),
                       in_hand.round());
    PRIMO_ASSIGN(const auto watcher, context.make_watcher());
    PRIMO_ASSIGN(const auto evaluator, graph::DdsEvaluator::create(context.participant(), *watcher, waiting, client));
    context.status().job_started();
    const auto goal = wire::from_wire(in_hand);
    const auto on_progress = [&](const study::Progress& state) {
      if (const auto status = progress.publish(state); !status.ok()) context.log().warn("{}", status.error().message);
    };
    const auto result = goal.ok() ? study::optimize_in_directory(*goal, *evaluator, on_progress)
                                  : Result<study::OptimizeResult>(goal.error());
    context.status().job_finished(result.ok(), result.ok() ? "" : result.error().message);
    if (context.stopping() || desk.replaced(in_hand, change)) continue;

    topics::msg::OptimizedPrimitive answer;
    if (result.ok()) {
      answer = wire::to_wire(*result);
    } else {
      context.log().error("{}", result.error().message);
      answer.error(result.error().message);
    }
    answer.study(in_hand.study());
    answer.round(in_hand.round());
    answer.primitive().action(in_hand.primitive().action());
    answer.action(in_hand.primitive().action());
    answer.request(desk.request(change));
    PRIMO_TRY(publisher.publish(answer));
  }
  return success();
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) {
  return primo::service::run<primo::OptimizerConfig>("optimizer", argc, argv, primo::run);
}

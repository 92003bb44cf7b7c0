#include "study/local_workers.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "motion/planner.h"
#include "physics/depth_camera.h"
#include "rules/learner.h"
#include "scene/perception.h"
#include "study/loop.h"
#include "study/rollout.h"

namespace primo::study {
namespace {

Error stopped() { return {Code::unavailable, "stopped"}; }

/// Runs work(0) … work(count − 1) on threads and hands every result to `on_result` on the calling thread, in the order
/// of arrival. The first error ends it.
template <class T>
Status in_parallel(std::size_t count, int threads, const std::function<bool()>& stopping,
                   const std::function<Result<T>(std::size_t)>& work,
                   const std::function<void(std::size_t, T)>& on_result) {
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::mutex mutex;
  std::condition_variable arrived;
  std::deque<std::pair<std::size_t, Result<T>>> done;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> end{false};
  const std::size_t workers = std::min(count, static_cast<std::size_t>(threads));
  std::vector<std::jthread> pool;
  for (std::size_t w = 0; w < workers; ++w) {
    pool.emplace_back([&] {
      for (std::size_t i = next++; i < count && !end; i = next++) {
        Result<T> result = stopping && stopping() ? Result<T>(stopped()) : work(i);
        const std::lock_guard lock(mutex);
        done.emplace_back(i, std::move(result));
        arrived.notify_one();
      }
    });
  }
  for (std::size_t received = 0; received < count; ++received) {
    std::unique_lock lock(mutex);
    arrived.wait(lock, [&] { return !done.empty(); });
    auto [i, result] = std::move(done.front());
    done.pop_front();
    lock.unlock();
    if (!result) {
      end = true;
      pool.clear();  // joins
      return result.error();
    }
    on_result(i, std::move(*result));
  }
  return success();
}

}  // namespace

Result<std::unique_ptr<LocalWorkers>> LocalWorkers::create(const std::filesystem::path& robot_file,
                                                           LocalOptions options) {
  PRIMO_ASSIGN(auto robot, robot::Robot::load(robot_file));
  return std::unique_ptr<LocalWorkers>(new LocalWorkers(std::move(robot), std::move(options)));
}

LocalWorkers::LocalWorkers(robot::Robot robot, LocalOptions options)
    : robot_(std::move(robot)), judge_(robot_), options_(std::move(options)) {}

Result<RolloutResult> LocalWorkers::roll_out(const Rollout& rollout) const {
  return judge(rollout, motion::plan(robot_, plan_request(rollout)));
}

Result<RolloutResult> LocalWorkers::judge(const Rollout& rollout, const motion::Plan& plan) const {
  if (!has_trajectory(plan)) return rollout_without_plan(plan);
  auto verdict = judge_.evaluate(judge_request(rollout, plan));
  if (!verdict) return verdict.error().at("judge, scenario " + rollout.scenario.name);
  return rollout_result(plan, std::move(*verdict));
}

Status LocalWorkers::evaluate(std::span<const Rollout> rollouts,
                              const std::function<void(std::size_t index, RolloutResult result)>& on_result) {
  return in_parallel<RolloutResult>(
      rollouts.size(), options_.threads, options_.stopping, [&](std::size_t i) { return roll_out(rollouts[i]); },
      on_result);
}

Result<std::vector<scene::SceneEstimate>> LocalWorkers::observe(std::span<const scene::Scenario> scenarios) {
  std::vector<scene::SceneEstimate> estimates(scenarios.size());
  PRIMO_TRY(in_parallel<scene::SceneEstimate>(
      scenarios.size(), options_.threads, options_.stopping,
      [&](std::size_t i) { return observe_scenario(scenarios[i]); },
      [&](std::size_t i, scene::SceneEstimate estimate) { estimates[i] = std::move(estimate); }));
  return estimates;
}

Result<rules::RuleSet> LocalWorkers::learn(const std::string&, const std::vector<symbols::Experience>& experiences) {
  return rules::learn(experiences);
}

Result<OptimizeResult> LocalWorkers::optimize(const OptimizeGoal& goal) {
  return optimize_in_directory(goal, *this, options_.on_progress);
}

Result<scene::SceneEstimate> observe_scenario(const scene::Scenario& scenario) {
  const auto where = [&](const Error& error) { return error.at("scenario " + scenario.name); };
  auto clouds = physics::render_depth(scenario, {.lowest = scene::lowest_of_interest(scenario)});
  if (!clouds) return where(clouds.error());
  auto request = scene::perception_request(scenario, std::move(*clouds));
  request.octree = false;
  auto estimate = scene::perceive(request);
  if (!estimate) return where(estimate.error());
  std::vector<std::string> arguments;
  for (std::size_t a = 1; a < scenario.action.size(); ++a) {
    if (scenario.object(scenario.action[a]) != nullptr) arguments.push_back(scenario.action[a]);
  }
  if (auto status = scene::require_objects(*estimate, arguments); !status.ok()) return where(status.error());
  return estimate;
}

}  // namespace primo::study

// Completions, delivered on the thread that asks for them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>

namespace primo::bus {

/// Threads of the bus post; the owner's thread runs what was posted. One mailbox may serve several clients, so that one
/// thread can wait for planner and judge together.
class Mailbox {
 public:
  void post(std::function<void()> task) {
    {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(task));
    }
    changed_.notify_one();
  }

  /// Runs all that was posted; waits for the first up to `timeout`. Returns whether anything ran.
  bool run(std::chrono::milliseconds timeout) {
    std::deque<std::function<void()>> tasks;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, timeout, [&] { return !tasks_.empty(); });
      tasks.swap(tasks_);
    }
    for (auto& task : tasks) task();
    return !tasks.empty();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
};

}  // namespace primo::bus

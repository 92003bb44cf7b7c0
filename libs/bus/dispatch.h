// Which job goes to which worker, and when it goes to another. Pure bookkeeping: no threads, no transport, time comes
// in as an argument.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace primo::bus {

class DispatchTable {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  struct Assignment {
    std::uint64_t job;
    std::string worker;
    unsigned attempt;  ///< 1, 2, …
  };
  struct Failure {
    std::uint64_t job;
    std::string message;
  };

  /// `role` is for messages. @pre attempts ≥ 1
  DispatchTable(std::string role, Duration deadline, int attempts);

  /// A worker can be sent jobs, with that many credits (0: no more; what it has stays with it).
  void set_worker(const std::string& worker, unsigned credits);
  /// A worker is gone: its jobs go back to the head of the queue.
  void remove_worker(const std::string& worker);

  void add(std::uint64_t job);
  /// The jobs to send now, each with its worker; counts them as sent.
  std::vector<Assignment> assign(Time now);
  /// A worker answered. True when this is the job's first answer: it is done.
  bool answered(std::uint64_t job, const std::string& worker);
  /// A worker gave a job back, or it could not be sent: not an attempt; the worker is left in peace for a moment.
  void returned(std::uint64_t job, const std::string& worker, Time now);
  /// Sends jobs whose deadline has passed back to the queue.
  void expire(Time now);
  /// Jobs that have used up their attempts; they are forgotten.
  std::vector<Failure> take_failures();
  void clear();

  /// When expire() or assign() have something to do again without another call; nothing when only calls can change
  /// that.
  std::optional<Time> next_time() const;
  std::size_t pending() const { return jobs_.size(); }
  std::size_t waiting() const { return queue_.size(); }
  unsigned window() const;  ///< all workers' credits

 private:
  struct Copy {
    Time deadline;
    bool overdue = false;
  };
  struct Worker {
    unsigned credits = 0;
    std::map<std::uint64_t, Copy> jobs;  ///< in its hands, as far as is known
    Time rest_until{};
    int overdue = 0;
  };
  struct Job {
    unsigned attempts = 0;
    int copies = 0;                   ///< in the hands of live workers and not overdue
    std::set<std::string> tried;      ///< workers
    std::vector<std::string> course;  ///< what became of each attempt
  };

  using Workers = std::map<std::string, Worker>;

  Workers::iterator best_worker(const Job& job, std::uint64_t id, Time now);
  void back(std::uint64_t job, const std::string& what);

  std::string role_;
  Duration deadline_;
  unsigned attempts_;
  Workers workers_;
  std::map<std::uint64_t, Job> jobs_;
  std::deque<std::uint64_t> queue_;
  std::vector<Failure> failures_;
};

}  // namespace primo::bus

#include "bus/dispatch.h"

#include <algorithm>
#include <cstdio>
#include <tuple>
#include <utility>

#include "core/check.h"

namespace primo::bus {
namespace {
constexpr auto kRest = std::chrono::milliseconds(100);

std::string in_seconds(DispatchTable::Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", std::chrono::duration<double>(duration).count());
  return text;
}
}  // namespace

DispatchTable::DispatchTable(std::string role, Duration deadline, int attempts)
    : role_(std::move(role)), deadline_(deadline), attempts_(static_cast<unsigned>(attempts)) {
  PRIMO_CHECK(attempts >= 1, "a job needs an attempt");
}

void DispatchTable::set_worker(const std::string& worker, unsigned credits) { workers_[worker].credits = credits; }

void DispatchTable::remove_worker(const std::string& worker) {
  const auto found = workers_.find(worker);
  if (found == workers_.end()) return;
  const auto copies = std::move(found->second.jobs);
  workers_.erase(found);
  // Backwards, so that the queue's head has them in their order.
  for (auto copy = copies.rbegin(); copy != copies.rend(); ++copy) {
    const auto job = jobs_.find(copy->first);
    if (job == jobs_.end() || copy->second.overdue) continue;
    --job->second.copies;
    back(copy->first, worker + " died");
  }
}

void DispatchTable::add(std::uint64_t job) {
  const bool added = jobs_.try_emplace(job).second;
  PRIMO_CHECK(added, "a job id twice");
  queue_.push_back(job);
}

/// An attempt has come to nothing; the job goes to the head of the queue unless another attempt is under way or none is
/// left.
void DispatchTable::back(std::uint64_t id, const std::string& what) {
  Job& job = jobs_.at(id);
  job.course.push_back(what);
  if (job.copies > 0) return;
  if (job.attempts < attempts_) {
    queue_.push_front(id);
    return;
  }
  std::string message = "no " + role_ + " could do job " + std::to_string(id) + " in " + std::to_string(job.attempts) +
                        (job.attempts == 1 ? " attempt:" : " attempts:");
  for (const std::string& attempt : job.course) message += " " + attempt + ";";
  failures_.push_back({id, message + " see the logs of these workers"});
  jobs_.erase(id);
}

DispatchTable::Workers::iterator DispatchTable::best_worker(const Job& job, std::uint64_t id, Time now) {
  auto best = workers_.end();
  std::tuple<bool, int, double> best_rank;
  for (auto candidate = workers_.begin(); candidate != workers_.end(); ++candidate) {
    const auto& [name, worker] = *candidate;
    if (worker.credits <= worker.jobs.size() || worker.rest_until > now || worker.jobs.contains(id)) continue;
    const std::tuple<bool, int, double> rank(job.tried.contains(name), worker.overdue,
                                             static_cast<double>(worker.jobs.size()) / worker.credits);
    if (best == workers_.end() || rank < best_rank) {
      best = candidate;
      best_rank = rank;
    }
  }
  return best;
}

std::vector<DispatchTable::Assignment> DispatchTable::assign(Time now) {
  std::size_t room = 0;
  for (auto& [name, worker] : workers_) {
    if (worker.rest_until <= now) worker.rest_until = {};
    if (worker.rest_until == Time{} && worker.credits > worker.jobs.size()) room += worker.credits - worker.jobs.size();
  }
  std::vector<Assignment> assignments;
  // A job is passed over only when the workers with room have it in their hands already.
  for (auto next = queue_.begin(); next != queue_.end() && room > 0;) {
    const std::uint64_t id = *next;
    Job& job = jobs_.at(id);
    const auto worker = best_worker(job, id, now);
    if (worker == workers_.end()) {
      ++next;
      continue;
    }
    next = queue_.erase(next);
    --room;
    worker->second.jobs[id] = {now + deadline_};
    job.tried.insert(worker->first);
    ++job.copies;
    ++job.attempts;
    assignments.push_back({id, worker->first, job.attempts});
  }
  return assignments;
}

bool DispatchTable::answered(std::uint64_t id, const std::string& name) {
  if (const auto worker = workers_.find(name); worker != workers_.end()) {
    if (const auto copy = worker->second.jobs.find(id); copy != worker->second.jobs.end()) {
      if (copy->second.overdue) --worker->second.overdue;
      worker->second.jobs.erase(copy);
    }
  }
  if (jobs_.erase(id) == 0) return false;
  // A late answer may overtake a new attempt that hasn't been sent yet.
  std::erase(queue_, id);
  return true;
}

void DispatchTable::returned(std::uint64_t id, const std::string& name, Time now) {
  const auto worker = workers_.find(name);
  if (worker == workers_.end()) return;
  worker->second.rest_until = now + kRest;
  const auto copy = worker->second.jobs.find(id);
  if (copy == worker->second.jobs.end()) return;
  const bool overdue = copy->second.overdue;
  if (overdue) --worker->second.overdue;
  worker->second.jobs.erase(copy);
  const auto job = jobs_.find(id);
  if (job == jobs_.end() || overdue) return;
  --job->second.copies;
  --job->second.attempts;
  job->second.tried.erase(name);
  if (job->second.copies == 0) queue_.push_front(id);
}

void DispatchTable::expire(Time now) {
  for (auto& [name, worker] : workers_) {
    for (auto copy = worker.jobs.begin(); copy != worker.jobs.end();) {
      const std::uint64_t id = copy->first;
      if (copy->second.deadline > now) {
        ++copy;
        continue;
      }
      if (copy->second.overdue) {
        // Twice its deadline: its credit is given back, so that a worker that lost an answer isn't lost itself.
        --worker.overdue;
        copy = worker.jobs.erase(copy);
        continue;
      }
      copy->second = {copy->second.deadline + deadline_, true};
      ++worker.overdue;
      ++copy;
      if (const auto job = jobs_.find(id); job != jobs_.end()) {
        --job->second.copies;
        back(id, name + " didn't answer within " + in_seconds(deadline_));
      }
    }
  }
}

std::vector<DispatchTable::Failure> DispatchTable::take_failures() { return std::exchange(failures_, {}); }

void DispatchTable::clear() {
  jobs_.clear();
  queue_.clear();
  failures_.clear();
}

std::optional<DispatchTable::Time> DispatchTable::next_time() const {
  std::optional<Time> next;
  const auto consider = [&](Time time) {
    if (!next || time < *next) next = time;
  };
  for (const auto& [name, worker] : workers_) {
    for (const auto& [id, copy] : worker.jobs) consider(copy.deadline);
    if (!queue_.empty() && worker.rest_until != Time{}) consider(worker.rest_until);
  }
  return next;
}

unsigned DispatchTable::window() const {
  unsigned sum = 0;
  for (const auto& [name, worker] : workers_) sum += worker.credits;
  return sum;
}

}  // namespace primo::bus

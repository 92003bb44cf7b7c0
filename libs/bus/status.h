// What every process says of itself, and the table of who is alive.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bus/participant.h"
#include "core/result.h"

namespace primo::bus {

enum class State { starting, waiting, idle, busy, draining };
}  // namespace primo::bus

template <>
struct primo::config::EnumNames<primo::bus::State> {
  static constexpr std::array<std::string_view, 5> names = {"starting", "waiting", "idle", "busy", "draining"};
};

namespace primo::bus {

struct WorkerInfo {
  std::string worker;  ///< Participant::id()
  std::string name, role, host;
  int pid = 0;
  State state = State::starting;
  std::string waiting_for;
  unsigned credits = 0;  ///< jobs one requester may have with it at a time; 0: takes none
  std::uint64_t jobs_done = 0, jobs_failed = 0;
  double jobs_per_second = 0;  ///< over the last seconds
  std::string last_error;
  std::string config_hash, version;
};

struct StatusSettings {
  std::string role;
  unsigned credits = 0;
  std::string config_hash, version;
  std::chrono::milliseconds lease{500};  ///< others notice a death within this; the heartbeat is a third of it
  /// Called, with why, when this process will hear nothing more: it was stopped for longer than `membership`, which is
  /// to be BusSettings::lease_ms, so that others have forgotten it and DDS does not introduce it to them again.
  std::chrono::milliseconds membership{10000};
  std::function<void(const std::string& why)> on_lost = {};
};

/// Publishes this process's status and keeps asserting its liveliness from a thread of its own. Thread-safe.
/// Counts and changes between idle and busy are published once a second, all else at once.
class StatusPublisher {
 public:
  static Result<std::unique_ptr<StatusPublisher>> create(const Participant& participant, StatusSettings settings);
  ~StatusPublisher();

  void set_state(State state);
  /// Says what the process waits for, and is in State::waiting until it says "" (then idle).
  void waiting_for(const std::string& text);
  void set_credits(unsigned credits);
  void job_started();
  void job_finished(bool ok, const std::string& error = {});
  void set_error(const std::string& text);
  WorkerInfo info() const;
  std::chrono::milliseconds lease() const;

  struct Impl;

 private:
  explicit StatusPublisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

enum class WorkerEvent { joined, updated, died };

/// Follows everybody's status. Thread-safe.
class StatusWatcher {
 public:
  using Callback = std::function<void(WorkerEvent event, const WorkerInfo& worker)>;

  /// `lease`: until a silent process counts as dead; publishers with a longer one don't match.
  static Result<std::unique_ptr<StatusWatcher>> create(
      const Participant& participant, std::chrono::milliseconds lease = std::chrono::milliseconds(500));
  ~StatusWatcher();

  /// Those alive, in order of role, name and worker.
  std::vector<WorkerInfo> workers() const;
  /// Those alive of a role.
  std::vector<WorkerInfo> workers(const std::string& role) const;
  /// Whether that many of a role (credits or not, not draining) are there within the time.
  bool wait_for(const std::string& role, int count, std::chrono::milliseconds timeout) const;

  /// Calls back for everyone alive (joined) and every later event, one at a time, until cancelled. No call runs after
  /// cancel() returned, unless that is called from the callback itself.
  int subscribe(Callback callback);
  void cancel(int subscription);

  struct Impl;

 private:
  explicit StatusWatcher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace primo::bus

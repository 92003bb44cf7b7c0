// A process's membership in a DDS domain: its transports, its identity and what goes wrong between its topics and
// others'.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/result.h"

namespace primo::bus {

struct BusSettings {
  int domain = 0;
  std::optional<int>
      domain_override;  ///< from a command line; stronger than PRIMO_DOMAIN, which is stronger than `domain`
  bool shared_memory = true;
  int segment_mib = 16;  ///< of shared memory, for what this process sends
  int socket_buffer_mib = 4;
  std::vector<std::string> peers;  ///< addresses of other hosts; empty: multicast alone
  int lease_ms =
      10000;  ///< until a silent process is forgotten; workers' deaths are noticed by their status, much sooner
  int max_sample_mib = 64;  ///< larger samples are refused on both sides
  template <class V>
  void visit(V&& v) {
    v("domain", domain, {.help = "DDS domain; PRIMO_DOMAIN and --domain override it", .min = 0, .max = 232});
    v("shared_memory", shared_memory, {.help = "use shared memory between processes of one host"});
    v("segment_mib", segment_mib,
      {.help = "shared memory for what this process sends", .unit = "MiB", .min = 4, .max = 1024});
    v("socket_buffer_mib", socket_buffer_mib, {.help = "UDP buffers", .unit = "MiB", .min = 1, .max = 256});
    v("peers", peers, {.help = "addresses of other hosts; empty: multicast alone"});
    v("lease_ms", lease_ms,
      {.help = "until a silent process is forgotten; workers' deaths are noticed sooner",
       .unit = "ms",
       .min = 200,
       .max = 600000});
    v("max_sample_mib", max_sample_mib, {.help = "larger samples are refused", .unit = "MiB", .min = 1, .max = 1024});
  }
};

/// The domain that counts: the override, else the environment's PRIMO_DOMAIN, else the settings'. Error: not a number
/// in 0 … 232.
Result<int> effective_domain(const BusSettings& settings);

/// A handle; copies share the membership, which ends with the last copy and the last reader or writer made from it.
class Participant {
 public:
  /// Joins the domain as `name` (letters, digits, '_', '-', '.'). Errors: config for a bad setting, unavailable when
  /// shared memory or ports cannot be had.
  static Result<Participant> create(const BusSettings& settings, const std::string& name);

  const std::string& name() const;
  /// "name-incarnation": unique in the domain for all time; the partition of this process's jobs and replies.
  const std::string& id() const;
  int domain() const;
  const std::string& host() const;

  /// What went wrong so far, oldest first: QoS that doesn't match, malformed samples. Each is logged once as well.
  std::vector<std::string> problems() const;
  /// Called for each further problem, from the bus's own thread.
  void on_problem(std::function<void(const std::string&)> callback);

  struct Impl;
  const std::shared_ptr<Impl>& impl() const { return impl_; }

 private:
  explicit Participant(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<Impl> impl_;
};

}  // namespace primo::bus

// Untyped readers and writers under the typed ones of latched.h, job_client.h and job_server.h.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <typeindex>

#include "bus/participant.h"
#include "bus/topics.h"
#include "core/result.h"

namespace primo::bus {

/// Where a sample came from: one writer's identity in the domain.
using Origin = std::array<unsigned char, 16>;

struct EndpointOptions {
  std::string partition;  ///< empty: the default partition
  /// Lease of MANUAL_BY_TOPIC liveliness; only for Quality::status.
  std::chrono::milliseconds lease{500};
  /// For tests and tools: another quality than the topic's table says.
  std::optional<Quality> quality = std::nullopt;
};

class Writer {
 public:
  /// @pre `type` is the topic's. Error: unavailable.
  static Result<std::unique_ptr<Writer>> create(const Participant& participant, const TopicInfo& topic,
                                                std::type_index type, EndpointOptions options = {},
                                                std::function<void()> on_matched = {});
  ~Writer();
  /// Waits at most 2 s for room. Errors: unavailable when there is none, data when the sample is too large.
  Status write(const void* sample);
  Status assert_liveliness();
  int matched() const;       ///< readers
  bool was_matched() const;  ///< whether there ever was a reader
  /// Whether that many readers match within the time.
  bool wait_matched(int count, std::chrono::milliseconds timeout) const;
  /// Waits until everything written was received by the readers matched now.
  bool wait_acknowledged(std::chrono::milliseconds timeout);

  struct Impl;

 private:
  explicit Writer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct ReaderCallbacks {
  /// A valid sample of the topic's type; the callee may move from it.
  std::function<void(void* sample, const Origin& origin)> on_sample;
  /// A writer became alive or stopped being so (liveliness lost, unmatched, disposed of its process). May be empty.
  std::function<void(const Origin& origin, bool alive)> on_writer;
};

/// Samples are taken, and all callbacks made, on the reader's own thread, with no lock held.
class Reader {
 public:
  /// @pre `type` is the topic's. Error: unavailable.
  static Result<std::unique_ptr<Reader>> create(const Participant& participant, const TopicInfo& topic,
                                                std::type_index type, ReaderCallbacks callbacks,
                                                EndpointOptions options = {});
  ~Reader();            ///< no callback runs afterwards. @pre not called from one
  int matched() const;  ///< writers

  struct Impl;

 private:
  explicit Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace primo::bus

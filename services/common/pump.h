// Many jobs through a few workers: starts jobs as far as the workers' windows go, and waits until all have come back.
#pragma once

#include <functional>
#include <memory>

#include "bus/mailbox.h"
#include "core/result.h"

namespace primo::graph {

/// How a service waits: what tells it to stop, and whom it tells what it waits for ("" when it no longer does).
struct Waiting {
  std::function<bool()> stopping;
  std::function<void(const std::string&)> waiting_for;
};

struct PumpState;

/// Reports the end of one job. Further calls are ignored, and all calls once the pump has returned.
class Finished {
 public:
  explicit Finished(std::shared_ptr<PumpState> state);
  void operator()(const Status& status) const;
  /// Whether the pump still runs. A completion that comes later must touch nothing that belongs to its caller.
  bool active() const;

 private:
  std::shared_ptr<PumpState> state_;
  std::shared_ptr<bool> reported_;
};

/// Starts jobs 0 … n−1 in order, at most `window()` under way, and runs the mailbox on the calling thread until all
/// have finished. The first error ends it: `cancel` is called and the error returned. So does stopping(), with
/// Code::unavailable.
Status pump(bus::Mailbox& mailbox, const Waiting& waiting, std::size_t n, const std::function<std::size_t()>& window,
            const std::function<void(std::size_t index, Finished finished)>& start,
            const std::function<void()>& cancel);

/// Runs the mailbox until `done()`, or stopping(): then Code::unavailable.
Status run_until(bus::Mailbox& mailbox, const Waiting& waiting, const std::function<bool()>& done);

}  // namespace primo::graph

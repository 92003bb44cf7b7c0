#include "common/pump.h"

#include <memory>

namespace primo::graph {
namespace {
constexpr std::chrono::milliseconds kTick{50};  // how soon a stop is noticed

Error stopped() { return {Code::unavailable, "told to stop before the work was done"}; }
}  // namespace

Status pump(bus::Mailbox& mailbox, const Waiting& waiting, std::size_t n, const std::function<std::size_t()>& window,
            const std::function<void(std::size_t, Finished)>& start, const std::function<void()>& cancel) {
  // Shared with the completions, which may outlive this call in the mailbox.
  struct State {
    bool active = true;
    std::size_t under_way = 0, done = 0;
    Status status = success();
  };
  const auto state = std::make_shared<State>();
  const auto give_up = [&](const Error& error) -> Status {
    state->active = false;
    cancel();
    return error;
  };
  for (std::size_t next = 0; state->done < n;) {
    while (next < n && state->status.ok() && state->under_way < window()) {
      ++state->under_way;
      const std::size_t index = next++;
      start(index, [state, reported = std::make_shared<bool>(false)](const Status& status) {
        if (!state->active || *reported) return;
        *reported = true;
        --state->under_way;
        ++state->done;
        if (!status.ok() && state->status.ok()) state->status = status;
      });
    }
    if (!state->status.ok()) return give_up(state->status.error());
    if (waiting.stopping()) return give_up(stopped());
    if (state->done < n) mailbox.run(kTick);
  }
  state->active = false;
  return success();
}

Status run_until(bus::Mailbox& mailbox, const Waiting& waiting, const std::function<bool()>& done) {
  while (!done()) {
    if (waiting.stopping()) return stopped();
    mailbox.run(kTick);
  }
  return success();
}

}  // namespace primo::graph

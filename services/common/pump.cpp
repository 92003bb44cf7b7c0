#include "common/pump.h"

#include <chrono>

namespace primo::graph {
namespace {
constexpr std::chrono::milliseconds kTick{50};       // how soon a stop is noticed
constexpr std::chrono::milliseconds kLongTick{200};  // the same, where what is waited for takes seconds

Error stopped() { return {Code::unavailable, "told to stop before the work was done"}; }
}  // namespace

struct PumpState {
  bool active = true;
  std::size_t under_way = 0, done = 0;
  Status status = success();
};

Finished::Finished(std::shared_ptr<PumpState> state)
    : state_(std::move(state)), reported_(std::make_shared<bool>(false)) {}

void Finished::operator()(const Status& status) const {
  if (!active() || *reported_) return;
  *reported_ = true;
  --state_->under_way;
  ++state_->done;
  if (!status.ok() && state_->status.ok()) state_->status = status;
}

bool Finished::active() const { return state_->active; }

Status pump(bus::Mailbox& mailbox, const Waiting& waiting, std::size_t n, const std::function<std::size_t()>& window,
            const std::function<void(std::size_t, Finished)>& start, const std::function<void()>& cancel) {
  const auto state = std::make_shared<PumpState>();
  const auto give_up = [&](const Error& error) -> Status {
    state->active = false;
    cancel();
    return error;
  };
  for (std::size_t next = 0;;) {
    while (next < n && state->status.ok() && state->under_way < window()) {
      ++state->under_way;
      const std::size_t index = next++;
      start(index, Finished(state));
    }
    if (!state->status.ok()) return give_up(state->status.error());
    if (state->done == n) break;
    if (waiting.stopping()) return give_up(stopped());
    mailbox.run(kTick);
  }
  state->active = false;
  return success();
}

Status run_until(bus::Mailbox& mailbox, const Waiting& waiting, const std::function<bool()>& done) {
  while (!done()) {
    if (waiting.stopping()) return stopped();
    mailbox.run(kLongTick);
  }
  return success();
}

}  // namespace primo::graph

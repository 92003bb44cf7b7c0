#include "primo/progress_lines.h"

#include <unistd.h>

#include <cstdio>
#include <iostream>

namespace primo::tool {
namespace {

std::string format(const char* pattern, auto... values) {
  char text[128];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string text_of(const StageState& state, double seconds) {
  std::string text = format("%-9s", state.stage.c_str());
  text += format("%-22s", state.subject.c_str());
  text += format("%5d/%-5d", state.done, state.total);
  text += format("%7.1f/s", state.rate);
  text += state.finished ? format("%8.0f s       ", seconds) : format("%8.0f s left  ", state.seconds_left);
  if (state.searching) text += format("best γ %6.3f  ", state.best_gamma);
  if (state.success.trials > 0) text += "success " + state.success.text();
  return text;
}

}  // namespace

ProgressLines::ProgressLines() : terminal_(::isatty(STDOUT_FILENO) == 1) {}

void ProgressLines::show(const StageState& state) {
  const std::string stage = std::to_string(state.round) + "/" + state.stage + "/" + state.subject;
  if (stage != stage_) {
    close();
    stage_ = stage;
    begin_ = Clock::now();
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  StageState shown = state;
  // Over a finished stage the mean rate says more than that of its last seconds.
  if (state.finished && seconds > 0.5) shown.rate = state.done / seconds;
  last_ = text_of(shown, seconds);
  open_ = true;
  if (terminal_) std::cout << "\r\033[K" << last_ << std::flush;
  if (state.finished) close();
}

void ProgressLines::say(const std::string& text) {
  if (terminal_ && open_) std::cout << "\r\033[K";
  std::cout << text << std::endl;
  if (terminal_ && open_) std::cout << last_ << std::flush;
}

void ProgressLines::close() {
  if (!open_) return;
  std::cout << (terminal_ ? "" : last_) << std::endl;
  open_ = false;
  stage_.clear();
}

}  // namespace primo::tool

#include "primo/progress_lines.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

namespace primo::tool {
namespace {

std::string format(const char* pattern, auto... values) {
  char text[160];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string text_of(const StageState& state, double seconds) {
  std::string text = format("%-18s ", state.part.c_str()) + format("%-11s", state.stage.c_str());
  text += format("%-22s", state.subject.c_str());
  text += format("%5d/%-5d", state.done, state.total);
  text += format("%7.1f/s", state.rate);
  text += state.finished ? format("%8.0f s       ", seconds) : format("%8.0f s left  ", state.seconds_left);
  if (state.searching) text += format("γ best %.3f mean %.3f  ", state.best_gamma, state.mean_gamma);
  if (state.searching && state.sigma > 0) text += format("σ %.3f cond %.0e  ", state.sigma, state.condition);
  if (state.success.trials > 0) text += "success " + state.success.text();
  return text;
}

/// The first characters of a line that fit into the terminal: a line that wraps cannot be written over.
std::string fitted(const std::string& text) {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return text;
  std::size_t end = 0;
  for (int columns = 0; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xC0) != 0x80;  // of a character in UTF-8
    if (begins && ++columns >= size.ws_col) break;
  }
  return text.substr(0, end);
}

}  // namespace

ProgressLines::ProgressLines() : terminal_(::isatty(STDOUT_FILENO) == 1) {}

void ProgressLines::show(const StageState& state) {
  const std::string stage = state.part + "/" + std::to_string(state.round) + "/" + state.stage + "/" + state.subject;
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
  if (terminal_) std::cout << "\r\033[K" << fitted(last_) << std::flush;
  if (state.finished) close();
}

void ProgressLines::say(const std::string& text) {
  if (terminal_ && open_) std::cout << "\r\033[K";
  std::cout << text << std::endl;
  if (terminal_ && open_) std::cout << fitted(last_) << std::flush;
}

void ProgressLines::close() {
  if (!open_) return;
  std::cout << (terminal_ ? "" : last_) << std::endl;
  open_ = false;
  stage_.clear();
}

}  // namespace primo::tool

// Ctrl-C and SIGTERM as a flag, for work that stops by itself between two steps.
#pragma once

namespace primo::tool {

/// From now on the signals set the flag and do not end the process.
void catch_interrupts();
bool interrupted();

/// What a process ends with that was interrupted: 128 + SIGINT, as shells say it.
inline constexpr int kInterrupted = 130;

}  // namespace primo::tool

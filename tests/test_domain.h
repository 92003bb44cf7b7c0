// A DDS domain that no other test of this machine is in.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <string>

namespace primo {

/// Held by a lock until this process ends; tests/system/running_graph.py takes its own in the same way. Of 1 to 99: the
/// UDP ports of those above 100 are among those that Linux gives to whoever asks for any.
inline int test_domain() {
  static const int domain = [] {
    constexpr int kDomains = 99;
    const int first = static_cast<int>(getpid() % kDomains);
    for (int i = 0; i < kDomains; ++i) {
      const int candidate = 1 + (first + i) % kDomains;
      const int file =
          open(("/tmp/primo_test_domain_" + std::to_string(candidate)).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0) return candidate;
      if (file >= 0) close(file);
    }
    return 1 + first;
  }();
  return domain;
}

}  // namespace primo

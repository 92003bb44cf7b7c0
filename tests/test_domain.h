// A DDS domain that no other test of this machine is in.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <string>

namespace primo {

/// Held by a lock until this process ends. Of 100 to 199; tests/system/running_graph.py takes those below in the same
/// way.
inline int test_domain() {
  static const int domain = [] {
    const int first = static_cast<int>(getpid() % 100);
    for (int i = 0; i < 100; ++i) {
      const int candidate = 100 + (first + i) % 100;
      const int file =
          open(("/tmp/primo_test_domain_" + std::to_string(candidate)).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0) return candidate;
      if (file >= 0) close(file);
    }
    return 100 + first;
  }();
  return domain;
}

}  // namespace primo

// What the bus's tests share: a domain of this process's own, short names, patience.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "../../test_domain.h"
#include "bus/participant.h"

namespace primo::bus {

inline BusSettings test_settings() {
  BusSettings settings;
  settings.domain_override = test_domain();
  settings.segment_mib = 4;
  return settings;
}

inline Participant make_participant(const std::string& name) {
  auto made = Participant::create(test_settings(), name);
  PRIMO_CHECK(made.ok(), made.error().message);
  return std::move(made).value();
}

/// Whether the condition comes true within the time.
inline bool eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds timeout = std::chrono::seconds(30)) {
  const auto until = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace primo::bus

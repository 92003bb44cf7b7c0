// Always-on checks for programmers' errors.
#pragma once

#include <string>

namespace primo {
[[noreturn]] void check_failed(const char* condition, const char* file, int line, const std::string& message);
}

#define PRIMO_CHECK(condition, message)                                               \
  do {                                                                                \
    if (!(condition)) ::primo::check_failed(#condition, __FILE__, __LINE__, message); \
  } while (false)

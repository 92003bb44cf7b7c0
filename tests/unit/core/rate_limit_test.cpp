#include "core/rate_limit.h"

#include <gtest/gtest.h>

namespace primo {
namespace {
using namespace std::chrono_literals;

TEST(RateLimit, lets_through_the_first_and_then_as_many_a_second_as_it_says) {
  const RateLimit::Clock::time_point start{};
  RateLimit limit(5);
  int passed = 0;
  for (auto t = 0ms; t < 2000ms; t += 10ms) passed += limit.due(start + t);
  EXPECT_EQ(passed, 10);  // at 0, 200, … 1800 ms
  EXPECT_TRUE(limit.due(start + 1h));
  EXPECT_FALSE(limit.due(start + 1h + 199ms));
}

TEST(RateLimit, of_zero_is_never) {
  RateLimit never(0);
  EXPECT_FALSE(never.due());
  EXPECT_FALSE(never.due(RateLimit::Clock::now() + std::chrono::hours(1)));
}

}  // namespace
}  // namespace primo

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "core/files.h"
#include "core/hash.h"
#include "core/pose.h"
#include "core/random.h"
#include "core/statistics.h"

namespace primo {
namespace {

TEST(Philox, matches_the_published_known_answers) {
  // kat_vectors of Random123: philox4x32 10.
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}),
            (std::array<std::uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox4x32({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
            (std::array<std::uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (std::array<std::uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, streams_depend_on_seed_purpose_and_indices_only) {
  Random a(7, "jiggle", {1, 2}), b(7, "jiggle", {1, 2});
  for (int i = 0; i < 100; ++i) ASSERT_EQ(a.bits(), b.bits());
  std::set<std::uint64_t> first;
  for (std::uint64_t i = 0; i < 20; ++i) {
    first.insert(Random(7, "jiggle", {i}).bits());
    first.insert(Random(i, "jiggle", {100}).bits());
    first.insert(Random(7, "other", {i}).bits());
  }
  EXPECT_EQ(first.size(), 60u);
}

TEST(Random, normal_has_the_moments_of_the_standard_normal) {
  Random random(3, "moments");
  double m1 = 0, m2 = 0, m4 = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    m1 += x / n;
    m2 += x * x / n;
    m4 += x * x * x * x / n;
  }
  EXPECT_NEAR(m1, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(m2, 1, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m4, 3, 5 * std::sqrt(96.0 / n));
}

TEST(Random, below_is_uniform) {
  Random random(3, "below");
  std::array<int, 6> counts{};
  for (int i = 0; i < 60000; ++i) ++counts[random.below(6)];
  double chi2 = 0;
  for (const int c : counts) chi2 += (c - 1e4) * (c - 1e4) / 1e4;
  EXPECT_LT(chi2, 20.5);  // 99.9 % of χ² with 5 degrees of freedom
}

TEST(Rate, wilson_interval_matches_the_closed_form_roots) {
  // The ends solve |p̂ − p| = z √(p(1−p)/n).
  for (const auto& [k, n] : {std::pair{5, 6}, {1, 50}, {300, 1200}}) {
    const Rate rate{k, n};
    for (const double p : {rate.lower(), rate.upper()}) {
      EXPECT_NEAR(std::abs(rate.value() - p), Rate::kZ95 * std::sqrt(p * (1 - p) / n), 1e-12);
    }
  }
  EXPECT_DOUBLE_EQ((Rate{0, 10}).lower(), 0.0);
  EXPECT_DOUBLE_EQ((Rate{10, 10}).upper(), 1.0);
  EXPECT_EQ((Rate{0, 0}).upper(), 1.0);
}

TEST(Hash, separates_strings_by_their_lengths_and_ignores_the_sign_of_zero) {
  EXPECT_NE(Hasher().add("ab").add("c").value(), Hasher().add("a").add("bc").value());
  EXPECT_EQ(Hasher().add(0.0).value(), Hasher().add(-0.0).value());
  EXPECT_EQ(hex(0x0123456789abcdefULL), "0123456789abcdef");
}

TEST(Pose, rpy_applies_roll_first_about_fixed_axes) {
  const Pose X = pose({1, 2, 3}, Eigen::Vector3d(M_PI / 2, 0, M_PI / 2));
  EXPECT_TRUE((X * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(1, 2, 4)));  // y → z by roll, z stays under yaw
}

TEST(Files, a_written_file_reads_back_and_leaves_no_temporary) {
  const auto folder = std::filesystem::temp_directory_path() / ("primo_files_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_file(folder / "a", "one").ok());
  ASSERT_TRUE(write_file(folder / "a", std::string("two\0x", 5)).ok());
  EXPECT_EQ(read_file(folder / "a").value(), std::string("two\0x", 5));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_EQ(read_file(folder / "missing").error().code, Code::config);
  EXPECT_EQ(write_file(folder / "no" / "such", "x").error().code, Code::failed);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace primo

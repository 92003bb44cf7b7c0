#include "primo/trajectory_json.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace primo::tool {
namespace {

motion::Plan plan(int joints = 3, int rows = 4) {
  Random random(1, "plan");
  motion::Plan plan;
  const auto matrix = [&](int r, int c) {
    Eigen::MatrixXd m(r, c);
    for (int i = 0; i < m.size(); ++i) m(i / c, i % c) = random.normal();
    return m;
  };
  for (int i = 0; i < joints; ++i) plan.trajectory.joints.push_back("joint_" + std::to_string(i));
  plan.trajectory.dt = 0.0625;
  plan.trajectory.q = matrix(rows, joints);
  for (int t = 0; t + 1 < rows; ++t) {
    plan.gains.K.push_back(matrix(joints, 2 * joints));
    plan.gains.k.emplace_back(matrix(joints, 1));
  }
  plan.iterations = 7;
  plan.rejected = 2;
  return plan;
}

std::string refusal(const std::string& text) {
  const auto read = plan_from_json(text);
  if (read.ok()) return "accepted";
  EXPECT_EQ(read.error().code, Code::data);
  return read.error().message;
}

/// The plan's file with one member exchanged.
std::string with(const char* key, const nlohmann::ordered_json& value) {
  auto json = trajectory_json(plan());
  json[key] = value;
  return json.dump();
}

TEST(TrajectoryJson, reads_back_what_was_written_to_the_last_bit) {
  const auto written = plan();
  const auto read = plan_from_json(trajectory_json(written).dump());
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->trajectory.q, written.trajectory.q);
  EXPECT_EQ(read->trajectory.joints, written.trajectory.joints);
  EXPECT_EQ(read->trajectory.dt, written.trajectory.dt);
  EXPECT_EQ(read->gains.K, written.gains.K);
  EXPECT_EQ(read->iterations, 9);
}

TEST(TrajectoryJson, says_what_is_wrong_and_where) {
  EXPECT_NE(refusal("").find("JSON"), std::string::npos);
  EXPECT_NE(refusal("[1, 2]").find("object"), std::string::npos);
  EXPECT_NE(refusal(R"({"joints": ["a"], "dt": NaN, "q": [[0]]})").find("JSON"), std::string::npos);
  EXPECT_NE(refusal(with("dt", "soon")).find("'dt'"), std::string::npos);
  EXPECT_NE(refusal(with("joints", {"a", 3})).find("'joints'"), std::string::npos);
  EXPECT_NE(refusal(with("joints", nlohmann::ordered_json::array())).find("'joints'"), std::string::npos);
  EXPECT_NE(refusal(with("q", {{1, 2, 3}, {1, 2}})).find("'q[1]'"), std::string::npos);
  EXPECT_NE(refusal(with("q", {{1, 2, 3}, {1, nullptr, 3}})).find("'q[1]'"), std::string::npos);
  EXPECT_NE(refusal(with("q", nlohmann::ordered_json::array())).find("'q'"), std::string::npos);
  EXPECT_NE(refusal(with("gains", {{"K", {{{1}}}}})).find("one matrix a step"), std::string::npos);
  EXPECT_NE(refusal(with("gains", {{"K", {{{1}}, {{1}}, {{1}}}}})).find("gains.K[0]"), std::string::npos);
  EXPECT_NE(refusal(with("iterations", -1)).find("'iterations'"), std::string::npos);
  EXPECT_NE(refusal(with("iterations", 1e300)).find("'iterations'"), std::string::npos);
}

TEST(TrajectoryJson, sizes_are_bounded_before_memory_is_asked_for) {
  // Three hundred thousand names and as many empty rows: a matrix of them would have 720 GB.
  std::string names = "\"\"", rows = "[]";
  for (int i = 1; i < 300000; ++i) names += ",\"\"", rows += ",[]";
  EXPECT_NE(refusal("{\"joints\":[" + names + "],\"dt\":1,\"q\":[" + rows + "]}").find("'joints'"), std::string::npos);
  EXPECT_NE(refusal("{\"joints\":[\"a\"],\"dt\":1,\"q\":[" + rows + "]}").find("300000 rows"), std::string::npos);
}

TEST(TrajectoryJson, answers_damaged_files_with_a_plan_or_a_sentence) {
  const std::string whole = trajectory_json(plan(2, 3)).dump();
  constexpr const char* kWords[] = {"null", "1e999", "-",    "[",   "]",      "{",   "}",
                                    "\"",   ",",     "true", "NaN", "1e-320", "[[]]"};
  int accepted = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    Random random(k, "damage");
    std::string text = whole;
    for (std::uint64_t change = 1 + random.below(3); change > 0 && !text.empty(); --change) {
      const std::size_t at = random.below(text.size()),
                        length = random.below(1 + std::min<std::size_t>(12, text.size() - at));
      switch (random.below(4)) {
        case 0:
          text.replace(at, length, kWords[random.below(std::size(kWords))]);
          break;
        case 1:
          text.erase(at, length);
          break;
        case 2:
          text.insert(at, text.substr(random.below(text.size()), length));
          break;
        default:
          text[at] = static_cast<char>(random.below(256));
      }
    }
    const auto read = plan_from_json(text);
    accepted += read.ok();
    if (!read.ok()) {
      ASSERT_FALSE(read.error().message.empty());
      continue;
    }
    // What was accepted is whole: it survives being written and read, and its sizes agree.
    const auto& q = read->trajectory.q;
    ASSERT_EQ(q.cols(), static_cast<Eigen::Index>(read->trajectory.joints.size()));
    ASSERT_TRUE(q.allFinite());
    const std::string again =
        trajectory_json(*read).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    ASSERT_TRUE(plan_from_json(again).ok()) << text;
  }
  EXPECT_GT(accepted, 100);
  EXPECT_LT(accepted, 19000);
}

}  // namespace
}  // namespace primo::tool

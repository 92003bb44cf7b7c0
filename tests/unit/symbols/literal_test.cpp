#include "symbols/literal.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "symbols/literal_json.h"
#include "unit/mutate.h"

namespace primo::symbols {
namespace {

const char* const kLine =
    R"({"objects":["c1","t"],"s":[["clear","c1"],["on","c1","t"]],"a":["grasp","c1"],"s2":[["inhand","c1"]]})";

std::string message(const std::string& line) {
  const auto read = experience_from_json(line);
  EXPECT_FALSE(read.ok()) << line;
  if (read.ok()) return "";
  EXPECT_EQ(read.error().code, Code::data);
  return read.error().message;
}

TEST(Literal, text_has_the_papers_form) {
  EXPECT_EQ((Literal{"on", {"c1", "t"}, true}.text()), "¬on(c1,t)");
  EXPECT_EQ((Literal{"inhand", {"X"}}.text()), "inhand(X)");
  EXPECT_EQ((Literal{"wet", {}}.text()), "wet");
}

TEST(Experience, is_read_from_and_written_as_the_published_line) {
  const auto read = experience_from_json(kLine);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->objects, (std::vector<std::string>{"c1", "t"}));
  EXPECT_EQ(read->before, (State{{"on", {"c1", "t"}}, {"clear", {"c1"}}}));
  EXPECT_EQ(read->action, (Literal{"grasp", {"c1"}}));
  EXPECT_EQ(read->after, (State{{"inhand", {"c1"}}}));
  EXPECT_EQ(to_json_line(*read), kLine);
}

TEST(Experience, keeps_its_id) {
  Experience experience{.id = "round 1/\"7\"\n", .objects = {}, .before = {}, .action = {"dry", {}}, .after = {}};
  const auto read = experience_from_json(to_json_line(experience));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->id, experience.id);
  EXPECT_EQ(to_json_line(experience).find('\n'), std::string::npos) << "one line";
}

TEST(Experience, errors_say_where_and_what_would_be_right) {
  EXPECT_NE(message("{").find("not JSON"), std::string::npos);
  EXPECT_NE(message("[]").find("objects, s, a and s2"), std::string::npos);
  EXPECT_NE(message(R"({"objects":[],"s":[],"a":["x"]})").find("lacks the key \"s2\""), std::string::npos);
  EXPECT_NE(message(R"({"objects":[],"s":[],"a":["x"],"s2":[],"S":1})").find("unknown key \"S\"; known: id"),
            std::string::npos);
  EXPECT_NE(message(R"({"objects":[],"s":[],"s":[],"a":["x"],"s2":[]})").find("stands twice"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["c"],"s":[["on","c","t"]],"a":["x"],"s2":[]})").find("s: on(c,t) mentions t"),
            std::string::npos);
  EXPECT_NE(message(R"({"objects":["c"],"s":[["not","wet"]],"a":["x"],"s2":[]})").find("negated"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["C"],"s":[],"a":["x"],"s2":[]})").find("lower case"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["c","c"],"s":[],"a":["x"],"s2":[]})").find("c stands twice"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["c"],"s":[[3]],"a":["x"],"s2":[]})").find("not a name: 3"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["c"],"s":[],"a":["not"],"s2":[]})").find("without a predicate"), std::string::npos);
  EXPECT_NE(message(R"({"objects":["c"],"s":[],"a":["x","c","c","c","c","c","c","c","c"],"s2":[]})").find("at most 7"),
            std::string::npos);
}

TEST(Experience, deep_nesting_is_refused_without_harm) {
  std::string deep = R"({"objects":)";
  for (int i = 0; i < 200000; ++i) deep += '[';
  EXPECT_FALSE(experience_from_json(deep).ok());
  for (int i = 0; i < 200000; ++i) deep += ']';
  EXPECT_NE(message(deep + R"(,"s":[],"a":["x"],"s2":[]})").find("deeper than"), std::string::npos);
}

TEST(Experience, mutated_lines_are_read_back_the_same_or_refused) {
  int accepted = 0;
  for (std::uint64_t round = 0; round < 20000; ++round) {
    Random random(1, "mutate", {round});
    const std::string line = test::mutated(kLine, random);
    const auto read = experience_from_json(line);
    if (!read.ok()) {
      EXPECT_FALSE(read.error().message.empty());
      continue;
    }
    ++accepted;
    const auto again = experience_from_json(to_json_line(*read));
    ASSERT_TRUE(again.ok()) << line;
    EXPECT_EQ(again->before, read->before);
    EXPECT_EQ(again->action, read->action);
    EXPECT_EQ(again->after, read->after);
  }
  EXPECT_GT(accepted, 100) << "the mutations must also produce valid lines";
}

}  // namespace
}  // namespace primo::symbols

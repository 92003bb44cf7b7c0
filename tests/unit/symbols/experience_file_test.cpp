#include "symbols/experience_file.h"

#include <gtest/gtest.h>

#include <sstream>

namespace primo::symbols {
namespace {

const std::string kGood = R"({"objects":["c","t"],"s":[["on","c","t"]],"a":["grasp","c"],"s2":[]})";

Result<ExperienceFileSummary> read(const std::string& text, bool skip_bad, std::vector<std::string>* places = nullptr) {
  std::istringstream lines(text);
  return read_experiences(lines, "file", {.skip_bad = skip_bad}, [&](Experience&&, const std::string& where) {
    if (places) places->push_back(where);
    return success();
  });
}

TEST(ExperienceFile, gives_each_line_with_its_number_and_passes_over_empty_ones) {
  std::vector<std::string> places;
  const auto summary = read(kGood + "\n\n  \r\n" + kGood, false, &places);
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_EQ(summary->experiences, 2);
  EXPECT_EQ(places, (std::vector<std::string>{"file:1", "file:4"}));
  EXPECT_EQ(read("", false)->experiences, 0);
}

TEST(ExperienceFile, names_line_and_reason_or_counts_what_is_bad) {
  const std::string text = kGood + "\n{\"objects\":\n" + kGood + "\nnonsense\n";
  const auto refused = read(text, false);
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(refused.error().message.starts_with("file:2: not JSON")) << refused.error().message;
  const auto skipped = read(text, true);
  ASSERT_TRUE(skipped.ok());
  EXPECT_EQ(skipped->experiences, 2);
  EXPECT_EQ(skipped->skipped, 2);
  EXPECT_TRUE(skipped->first_skipped.starts_with("file:2: ")) << skipped->first_skipped;
}

TEST(ExperienceFile, refuses_a_predicate_with_another_number_of_arguments) {
  const std::string odd = R"({"objects":["c"],"s":[["wet"],["on","c"]],"a":["grasp","c"],"s2":[]})";
  const auto refused = read(kGood + "\n" + odd, false);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "file:2: on has 1 argument, but 2 in file:1");
  const std::string action = R"({"objects":["c"],"s":[],"a":["grasp"],"s2":[]})";
  EXPECT_EQ(read(kGood + "\n" + action, false).error().message,
            "file:2: the action grasp has 0 arguments, but 1 in file:1");
  const std::string value = R"({"objects":["c","t"],"s":[["on","c","t",3]],"a":["grasp","c"],"s2":[]})";
  EXPECT_EQ(read(kGood + "\n" + value, false).error().message, "file:2: on has a value, other than in file:1");
  // A skipped line leaves no mark: wet was only in it.
  const std::string wet = R"({"objects":["c"],"s":[["wet","c"]],"a":["grasp","c"],"s2":[]})";
  EXPECT_EQ(read(kGood + "\n" + odd + "\n" + wet, true)->experiences, 2);
}

TEST(Fluent, values_and_ranges_are_read_and_written) {
  const std::string line =
      R"({"objects":["c"],"s":[["size","c",3],["hours",-2]],"a":["grow","c"],"s2":[["hours",-2],["size","c",4]]})";
  const auto read = experience_from_json(line);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(value_of(read->before, "size", {"c"}), 3);
  EXPECT_EQ(value_of(read->after, "size", {"c"}), 4);
  EXPECT_EQ(value_of(read->before, "hours", {}), -2);
  EXPECT_EQ(value_of(read->before, "size", {"d"}), std::nullopt);
  EXPECT_EQ(to_json_line(*experience_from_json(to_json_line(*read))), to_json_line(*read));
  EXPECT_EQ((Literal{"size", {"X"}, false, Relation::at_least, 3}).text(), "size(X)≥3");
  EXPECT_EQ((Literal{"size", {"X"}, true, Relation::equal, 3}).text(), "size(X)≠3");
}

TEST(Fluent, errors_say_what_is_wrong) {
  const auto refusal = [](const std::string& state) {
    const auto read = experience_from_json(R"({"objects":["c"],"s":)" + state + R"(,"a":["x"],"s2":[]})");
    return read.ok() ? "" : read.error().message;
  };
  EXPECT_NE(refusal(R"([["size","c",3],["size","c",4]])").find("a function has one value"), std::string::npos);
  EXPECT_NE(refusal(R"([[">=","size","c",3]])").find("is a range"), std::string::npos);
  EXPECT_NE(refusal(R"([[">=","size","c"]])").find("a range without its number"), std::string::npos);
  EXPECT_NE(refusal(R"([["size","c",1e10]])").find("not a name"), std::string::npos);
  EXPECT_NE(refusal(R"([["size","c",3000000000]])").find("from -1e9 to 1e9"), std::string::npos);
}

TEST(Fluent, a_literal_holds_and_is_made_true) {
  State state{{"size", {"c"}, false, Relation::equal, 3}};
  EXPECT_TRUE(holds({"size", {"c"}, false, Relation::at_most, 3}, state));
  EXPECT_FALSE(holds({"size", {"c"}, false, Relation::at_least, 4}, state));
  EXPECT_TRUE(holds({"size", {"d"}, true, Relation::equal, 3}, state)) << "no value is no 3";
  make_true({"size", {"c"}, false, Relation::equal, 5}, state);
  EXPECT_EQ(state, (State{{"size", {"c"}, false, Relation::equal, 5}}));
  make_true({"size", {"c"}, true, Relation::equal, 4}, state);
  EXPECT_EQ(state.size(), 1u) << "it is not 4 already";
  make_true({"size", {"c"}, true, Relation::equal, 5}, state);
  EXPECT_TRUE(state.empty());
}

TEST(Situation, is_read_from_the_keys_of_an_experience) {
  const auto situation = situation_from_json(kGood);
  ASSERT_TRUE(situation.ok()) << situation.error().message;
  EXPECT_EQ(situation->state, (State{{"on", {"c", "t"}}}));
  EXPECT_NE(situation_from_json(R"({"objects":[]})").error().message.find("lacks the key \"s\""), std::string::npos);
}

}  // namespace
}  // namespace primo::symbols

#include "symbols/derived.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "unit/mutate.h"

namespace primo::symbols {
namespace {

State derived(const std::string& text, const std::vector<std::string>& objects, const State& state) {
  const auto definitions = definitions_from_text(text, "test");
  EXPECT_TRUE(definitions.ok()) << (definitions.ok() ? "" : definitions.error().message);
  return definitions.ok() ? derive(*definitions, objects, state) : State{};
}

Literal number(const std::string& name, std::vector<std::string> arguments, std::int32_t value) {
  return {name, std::move(arguments), false, Relation::equal, value};
}

// a on b on c on table t; d on t.
const std::vector<std::string> kObjects{"a", "b", "c", "d", "t"};
const State kBlocks{{"on", {"a", "b"}}, {"on", {"b", "c"}}, {"on", {"c", "t"}}, {"on", {"d", "t"}}, {"table", {"t"}}};

TEST(Derive, gives_what_the_paper_reinvents_of_the_blocks_world) {
  EXPECT_EQ(derived("clear(X) := not exists Y: on(Y,X)", kObjects, kBlocks),
            (State{{"clear", {"a"}}, {"clear", {"d"}}}));
  EXPECT_EQ(derived("handempty := not exists X: inhand(X)", kObjects, kBlocks), (State{{"handempty", {}}}));
  EXPECT_EQ(derived("above(X,Y) := closure on(X,Y)", kObjects, kBlocks), (State{{"above", {"a", "b"}},
                                                                                {"above", {"a", "c"}},
                                                                                {"above", {"a", "t"}},
                                                                                {"above", {"b", "c"}},
                                                                                {"above", {"b", "t"}},
                                                                                {"above", {"c", "t"}},
                                                                                {"above", {"d", "t"}}}));
  const State heights = derived("above(X,Y) := closure on(X,Y)\nheight(X) := count Y: above(X,Y)", kObjects, kBlocks);
  for (const auto& [object, height] : std::map<std::string, int>{{"a", 3}, {"b", 2}, {"c", 1}, {"d", 1}, {"t", 0}}) {
    EXPECT_TRUE(heights.contains(number("height", {object}, height))) << object;
  }
  const State tops = derived(
      "above(X,Y) := closure on(X,Y)\n"
      "topstack(X,Y) := above(X,Y) and not exists Z: on(Z,X)   # the highest block over Y\n",
      kObjects, kBlocks);
  EXPECT_TRUE(tops.contains({"topstack", {"a", "c"}}));
  EXPECT_FALSE(tops.contains({"topstack", {"b", "c"}}));
}

TEST(Derive, different_variables_are_different_objects) {
  const State loop{{"p", {"a", "a"}}, {"p", {"a", "b"}}};
  EXPECT_EQ(derived("some(X) := exists Y: p(X,Y)", {"a", "b"}, loop), (State{{"some", {"a"}}}));
  EXPECT_EQ(derived("some(X) := exists Y: p(X,Y)", {"a", "b"}, {{"p", {"a", "a"}}}), State{});
}

TEST(Derive, compares_numbers_and_quantifies_over_all) {
  const State state{number("size", {"a"}, 3), number("size", {"b"}, 1), {"red", {"a"}}, {"red", {"c"}}};
  EXPECT_EQ(derived("big(X) := size(X) >= 2", {"a", "b", "c"}, state), (State{{"big", {"a"}}}));
  EXPECT_EQ(derived("odd(X) := size(X) != 3", {"a", "b", "c"}, state), (State{{"odd", {"b"}}, {"odd", {"c"}}}))
      << "what has no value is not 3";
  EXPECT_EQ(derived("all := forall X: (red(X))", {"a", "c"}, state), (State{{"all", {}}}));
  EXPECT_EQ(derived("all := forall X: red(X)", {"a", "b"}, state), State{});
}

TEST(Derive, closure_and_counts_agree_with_matrices_on_random_graphs) {
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    Random random(1, "graph", {trial});
    constexpr int kN = 6;
    bool reach[kN][kN] = {};
    State state;
    std::vector<std::string> objects;
    for (int i = 0; i < kN; ++i) objects.push_back(std::string(1, static_cast<char>('a' + i)));
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j < kN; ++j) {
        if (random.below(5) != 0) continue;
        reach[i][j] = true;
        state.insert({"e", {objects[static_cast<std::size_t>(i)], objects[static_cast<std::size_t>(j)]}});
      }
    }
    for (int k = 0; k < kN; ++k) {
      for (int i = 0; i < kN; ++i) {
        for (int j = 0; j < kN; ++j) reach[i][j] = reach[i][j] || (reach[i][k] && reach[k][j]);
      }
    }
    const State found =
        derived("r(X,Y) := closure e(X,Y)\nback(X,Y) := closure e(Y,X)\nn(X) := count Y: r(X,Y)", objects, state);
    for (int i = 0; i < kN; ++i) {
      int reached = 0;
      for (int j = 0; j < kN; ++j) {
        const auto &a = objects[static_cast<std::size_t>(i)], &b = objects[static_cast<std::size_t>(j)];
        EXPECT_EQ(found.contains({"r", {a, b}}), reach[i][j] && i != j) << a << b;
        EXPECT_EQ(found.contains({"back", {b, a}}), reach[i][j] && i != j) << a << b;
        reached += reach[i][j] && i != j;
      }
      EXPECT_TRUE(found.contains(number("n", {objects[static_cast<std::size_t>(i)]}, reached)));
    }
  }
}

std::string refusal(const std::string& text) {
  const auto read = definitions_from_text(text, "file");
  EXPECT_FALSE(read.ok()) << text;
  return read.ok() ? "" : read.error().message;
}

TEST(Definition, errors_say_the_line_and_what_is_wrong) {
  EXPECT_NE(refusal("\nclear(X) = on(X)").find("file:2: character 10: expected ':='"), std::string::npos);
  EXPECT_NE(refusal("a(X) := on(X,Y)").find("the variable Y is bound nowhere"), std::string::npos);
  EXPECT_NE(refusal("a(x) := on(x)").find("is no variable"), std::string::npos);
  EXPECT_NE(refusal("a(X,X) := on(X,X)").find("stands twice"), std::string::npos);
  EXPECT_NE(refusal("a(X) := closure on(X,Y)").find("a closure is name(X,Y)"), std::string::npos);
  EXPECT_NE(refusal("a := b\nb := c").find("a uses b, which is not defined before it"), std::string::npos);
  EXPECT_NE(refusal("a := b\na := c").find("a is defined twice"), std::string::npos);
  EXPECT_NE(refusal("a := a").find("a uses a"), std::string::npos);
  EXPECT_NE(refusal("a := size(b) >= many").find("a whole number"), std::string::npos);
  EXPECT_NE(refusal("a := exists X: exists X: p(X)").find("X is bound twice"), std::string::npos);
  EXPECT_NE(refusal("a := " + std::string(100, '(')).find("less nesting"), std::string::npos);
}

TEST(Definition, mutated_texts_are_read_back_the_same_or_refused) {
  const std::string kText = "top(X) := clear(X) and not exists Y: (on(X,Y) and not table(Y)) and height(X) >= 2";
  int accepted = 0;
  for (std::uint64_t round = 0; round < 20000; ++round) {
    Random random(2, "mutate", {round});
    const std::string text = test::mutated(kText, random);
    const auto read = definition_from_text(text);
    if (!read.ok()) {
      EXPECT_FALSE(read.error().message.empty());
      continue;
    }
    ++accepted;
    const auto again = definition_from_text(read->text());
    ASSERT_TRUE(again.ok()) << text << "\n" << read->text() << "\n" << again.error().message;
    EXPECT_EQ(*again, *read) << text;
  }
  EXPECT_GT(accepted, 100) << "the mutations must also produce valid texts";
}

}  // namespace
}  // namespace primo::symbols

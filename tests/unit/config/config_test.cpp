#include "config/config.h"

#include <gtest/gtest.h>

namespace primo::config {

enum class Colour { red, green };
template <>
struct EnumNames<Colour> {
  static constexpr std::array<std::string_view, 2> names = {"red", "green"};
};

namespace {

struct Inner {
  int count = 3;
  std::optional<double> scale;
  template <class V>
  void visit(V&& v) {
    v("count", count, {.help = "how many", .min = 1, .max = 10});
    v("scale", scale, {.unit = "m"});
  }
};

struct Outer {
  std::string name = "x";
  Eigen::Vector3d position{1, 2, 3};
  Colour colour = Colour::red;
  std::vector<Inner> list;
  std::map<std::string, double> weights;
  Inner inner;
  bool on = false;
  Status validate() const {
    if (name == "bad") return Error{Code::config, "'name' must not be bad"};
    return success();
  }
  template <class V>
  void visit(V&& v) {
    v("name", name, {});
    v("position", position, {});
    v("colour", colour, {});
    v("list", list, {});
    v("weights", weights, {});
    v("inner", inner, {});
    v("on", on, {});
  }
};

std::string refusal(const std::string& text) {
  auto result = read_text<Outer>(text, "f.yaml");
  EXPECT_FALSE(result.ok());
  return result.ok() ? "" : result.error().message;
}

TEST(Config, every_field_type_survives_a_dump) {
  const auto read = read_text<Outer>(
      "name: n\nposition: [0.1, 2, 1e-300]\ncolour: green\nlist: [{count: 2}, {scale: 0.30000000000000004}]\n"
      "weights: {a: 1, b: .inf}\ninner: {count: 7}\non: true\n",
      "f.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const auto again = read_text<Outer>(dump(*read), "dump");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(dump(*again), dump(*read));
  EXPECT_EQ(again->position, read->position);
  EXPECT_EQ(again->colour, Colour::green);
  EXPECT_EQ(again->list.at(1).scale, 0.30000000000000004);
  EXPECT_EQ(again->inner.count, 7);
}

TEST(Config, an_unknown_key_is_refused_with_its_line_and_a_suggestion) {
  EXPECT_EQ(refusal("name: a\ninner:\n  cuont: 2\n"), "f.yaml:3: unknown key 'inner.cuont'; did you mean 'count'?");
}

TEST(Config, bounds_types_and_names_are_checked) {
  EXPECT_EQ(refusal("inner: {count: 11}"), "f.yaml:1: 'inner.count' is 11, must be between 1 and 10");
  EXPECT_EQ(refusal("inner: {count: 2.5}"), "f.yaml:1: 'inner.count' must be a whole number");
  EXPECT_EQ(refusal("position: [1, 2]"), "f.yaml:1: 'position' must be a list of 3 numbers");
  EXPECT_EQ(refusal("position: [1, 2, nan]"), "f.yaml:1: 'position[2]' must be a number, not 'nan'");
  EXPECT_EQ(refusal("colour: blue"), "f.yaml:1: 'colour' is 'blue', expected one of red, green");
  EXPECT_EQ(refusal("name: bad"), "f.yaml: 'name' must not be bad");
  EXPECT_NE(refusal("name: [").find("not valid YAML"), std::string::npos);
  EXPECT_EQ(refusal("[1, 2]"), "f.yaml:1: the file must be a map of keys to values");
}

TEST(Config, overrides_reach_nested_keys_and_keep_the_rest) {
  auto node = override_keys(YAML::Load("inner: {count: 2}\nname: n"), {"inner.scale=0.5", "weights.a=2"});
  ASSERT_TRUE(node.ok());
  const auto read = read_node<Outer>(*node, "f");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->inner.count, 2);
  EXPECT_EQ(read->inner.scale, 0.5);
  EXPECT_EQ(read->weights.at("a"), 2);
  EXPECT_EQ(read->name, "n");
  EXPECT_EQ(override_keys(YAML::Load("a: 1"), {"a.b=2"}).error().code, Code::usage);
  EXPECT_EQ(override_keys(YAML::Load("a: 1"), {"nonsense"}).error().code, Code::usage);
}

TEST(Config, describe_lists_defaults_units_bounds_and_choices) {
  const std::string text = describe<Outer>();
  EXPECT_NE(text.find("inner.count: 3  [1, 10]  how many"), std::string::npos) << text;
  EXPECT_NE(text.find("colour: red  {red, green}"), std::string::npos) << text;
}

}  // namespace
}  // namespace primo::config

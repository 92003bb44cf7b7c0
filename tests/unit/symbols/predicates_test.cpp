#include "symbols/predicates.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

namespace primo::symbols {
namespace {

const SnapshotBody kTable{"t", BodyKind::table, pose({0.8, 0, 0.65}), {0.26, 0.26, 0.02}};

SnapshotBody cylinder(const std::string& name, const Eigen::Vector3d& at,
                      const Eigen::Vector3d& rpy = Eigen::Vector3d::Zero()) {
  return {name, BodyKind::cylinder, pose(at, rpy), {0.0375, 0.0375, 0.054}};
}

State observe_bodies(std::vector<SnapshotBody> bodies, std::set<std::string> in_hand = {}) {
  return observe({std::move(bodies), std::move(in_hand)});
}

TEST(Predicates, a_cylinder_standing_on_a_table_has_the_papers_context) {
  const State expected = {
      {"on", {"c1", "t"}}, {"cylinder", {"c1"}}, {"table", {"t"}}, {"clear", {"c1"}}, {"upright", {"c1"}}};
  EXPECT_EQ(observe_bodies({kTable, cylinder("c1", {0.8, 0.1, 0.724})}), expected);
}

TEST(Predicates, taking_a_cylinder_into_the_hand_changes_inhand_and_on_only) {
  const State before = observe_bodies({kTable, cylinder("c1", {0.8, 0.1, 0.724})});
  State expected = before;
  expected.erase({"on", {"c1", "t"}});
  expected.insert({"inhand", {"c1"}});
  EXPECT_EQ(observe_bodies({kTable, cylinder("c1", {0.8, 0.1, 0.724})}, {"c1"}), expected);
}

TEST(Predicates, a_stack_is_clear_only_at_its_top) {
  const State state = observe_bodies({kTable, cylinder("c1", {0.8, 0, 0.724}), cylinder("c2", {0.8, 0.01, 0.832})});
  EXPECT_TRUE(state.contains({"on", {"c2", "c1"}}));
  EXPECT_TRUE(state.contains({"on", {"c1", "t"}}));
  EXPECT_FALSE(state.contains({"on", {"c2", "t"}}));
  EXPECT_FALSE(state.contains({"clear", {"c1"}}));
  EXPECT_TRUE(state.contains({"clear", {"c2"}}));
}

TEST(Predicates, on_ends_beyond_the_support_tolerance_and_beyond_the_edge) {
  const Literal on{"on", {"c1", "t"}};
  EXPECT_TRUE(observe_bodies({kTable, cylinder("c1", {0.8, 0, 0.724 + 0.9 * kSupportTolerance})}).contains(on));
  EXPECT_FALSE(observe_bodies({kTable, cylinder("c1", {0.8, 0, 0.724 + 1.1 * kSupportTolerance})}).contains(on));
  EXPECT_TRUE(observe_bodies({kTable, cylinder("c1", {0.8, 0.259, 0.724})}).contains(on));
  EXPECT_FALSE(observe_bodies({kTable, cylinder("c1", {0.8, 0.261, 0.724})}).contains(on));
}

TEST(Predicates, a_lying_cylinder_is_on_the_table_but_not_upright) {
  const State state = observe_bodies({kTable, cylinder("c1", {0.8, 0, 0.67 + 0.0375}, {std::numbers::pi / 2, 0, 0.7})});
  EXPECT_TRUE(state.contains({"on", {"c1", "t"}}));
  EXPECT_FALSE(state.contains({"upright", {"c1"}}));
}

TEST(Predicates, upright_ends_at_its_tolerance_and_holds_either_way_up) {
  const auto upright = [](double roll) {
    return observe_bodies({cylinder("c1", {0.8, 0, 1}, {roll, 0, 0})}).contains({"upright", {"c1"}});
  };
  EXPECT_TRUE(upright(0.95 * kUprightTolerance));
  EXPECT_FALSE(upright(1.05 * kUprightTolerance));
  EXPECT_TRUE(upright(std::numbers::pi));
}

TEST(Predicates, a_turned_box_supports_what_is_over_its_own_rectangle) {
  const SnapshotBody box{
      "b", BodyKind::box, pose({0, 0, 0.1}, Eigen::Vector3d(0, 0, std::numbers::pi / 4)), {0.1, 0.01, 0.1}};
  // Along the box's long axis at 0.08 m: over the rectangle. At 0.08 m across: not, though the box around it in W
  // reaches there.
  EXPECT_TRUE(observe_bodies({box, cylinder("c", {0.0566, 0.0566, 0.254})}).contains({"on", {"c", "b"}}));
  EXPECT_FALSE(observe_bodies({box, cylinder("c", {0.0566, -0.0566, 0.254})}).contains({"on", {"c", "b"}}));
  EXPECT_TRUE(observe_bodies({box}).contains({"box", {"b"}}));
}

TEST(Predicates, extents_of_a_tilted_cylinder_follow_its_support_function) {
  const double tilt = 0.5;
  const auto body = cylinder("c", {0, 0, 1}, {tilt, 0, 0});
  const double half = 0.054 * std::cos(tilt) + 0.0375 * std::sin(tilt);
  EXPECT_NEAR(top_height(body), 1 + half, 1e-12);
  EXPECT_NEAR(bottom_height(body), 1 - half, 1e-12);
}

TEST(Predicates, every_entry_of_the_table_has_a_unique_name_and_makes_only_its_own_literals_of_its_arity) {
  const WorldSnapshot world{{kTable,
                             cylinder("c1", {0.8, 0, 0.724}),
                             cylinder("c2", {0.9, 0, 0.724}),
                             {"b", BodyKind::box, pose({0.7, 0, 0.72}), {0.05, 0.05, 0.05}}},
                            {"c2"}};
  std::set<std::string_view> names;
  for (const auto& predicate : predicates()) {
    EXPECT_TRUE(names.insert(predicate.name).second) << predicate.name;
    EXPECT_FALSE(predicate.meaning.empty());
    State state;
    predicate.observe(world, state);
    EXPECT_FALSE(state.empty()) << predicate.name << " sees nothing in a world that has an instance of everything";
    for (const auto& literal : state) {
      EXPECT_EQ(literal.predicate, predicate.name);
      EXPECT_EQ(static_cast<int>(literal.arguments.size()), predicate.arity);
      EXPECT_FALSE(literal.negated);
    }
  }
}

}  // namespace
}  // namespace primo::symbols

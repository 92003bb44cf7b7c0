#include "wire/wire.h"

#include <gtest/gtest.h>
#include <primo_jobsPubSubTypes.h>
#include <primo_motionPubSubTypes.h>
#include <primo_physicsPubSubTypes.h>
#include <primo_rulesPubSubTypes.h>
#include <primo_scenePubSubTypes.h>
#include <primo_studyPubSubTypes.h>
#include <rosPubSubTypes.h>

#include <cstring>
#include <limits>

#include "random_values.h"

namespace primo::wire {
namespace {

using eprosima::fastrtps::rtps::SerializedPayload_t;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class PubSubType, class Message>
std::vector<unsigned char> bytes_of(const Message& message) {
  static PubSubType type;
  void* data = const_cast<Message*>(&message);
  SerializedPayload_t payload(type.getSerializedSizeProvider(data)());
  EXPECT_TRUE(type.serialize(data, &payload));
  return {payload.data, payload.data + payload.length};
}

/// The message in these bytes, as a reader makes it; nothing when it refuses.
template <class PubSubType>
std::optional<typename PubSubType::type> message_of(const std::vector<unsigned char>& bytes) {
  static PubSubType type;
  typename PubSubType::type message;
  SerializedPayload_t payload(static_cast<std::uint32_t>(bytes.size()));
  std::memcpy(payload.data, bytes.data(), bytes.size());
  payload.length = static_cast<std::uint32_t>(bytes.size());
  try {
    if (type.deserialize(&payload, &message)) return message;
  } catch (const std::exception&) {  // what the bus's guard does
  }
  return std::nullopt;
}

/// There and back over CDR bytes, on random values; then every kind of damage to those bytes, which must end in a value
/// or an Error.
template <class PubSubType, class Make, class Encode>
void round_trip_and_damage(Make make, Encode encode) {
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto bytes = bytes_of<PubSubType>(encode(make(seed)));
    const auto message = message_of<PubSubType>(bytes);
    ASSERT_TRUE(message);
    const auto value = from_wire(*message);
    ASSERT_TRUE(value.ok()) << value.error().message;
    EXPECT_EQ(bytes_of<PubSubType>(encode(*value)), bytes) << "seed " << seed;

    Random random(seed, "damage");
    for (int i = 0; i < 40; ++i) {
      auto damaged = bytes;
      if (random.below(4) == 0) {
        damaged.resize(4 + random.below(damaged.size() - 3));
      } else {
        for (auto flips = 1 + random.below(4); flips > 0; --flips) {
          damaged[4 + random.below(damaged.size() - 4)] =
              static_cast<unsigned char>(random.below(3) == 0 ? 0xff : random.bits());
        }
      }
      const auto arrived = message_of<PubSubType>(damaged);
      if (!arrived) {
        ++refused;
        continue;
      }
      const auto converted = from_wire(*arrived);
      if (converted.ok()) continue;
      ++refused;
      EXPECT_TRUE(converted.error().code == Code::data || converted.error().code == Code::failed)
          << converted.error().message;
    }
  }
  EXPECT_GT(refused, 0);
}

const auto as_message = [](const auto& value) { return to_wire(value); };

TEST(Wire, scenarios_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::ScenarioPubSubType>([](auto seed) { return Draw(seed).scenario(); }, as_message);
}
TEST(Wire, clouds_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::PointCloudPubSubType>([](auto seed) { return Draw(seed).cloud(); }, as_message);
}
TEST(Wire, estimates_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::SceneEstimatePubSubType>([](auto seed) { return Draw(seed).estimate(); }, as_message);
}
TEST(Wire, primitives_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::PrimitivePubSubType>([](auto seed) { return Draw(seed).primitive(); }, as_message);
}
TEST(Wire, plan_requests_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::PlanRequestPubSubType>([](auto seed) { return Draw(seed).plan_request(); }, as_message);
}
TEST(Wire, plans_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::PlanPubSubType>([](auto seed) { return Draw(seed).plan(); }, as_message);
}
TEST(Wire, judge_requests_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::JudgeRequestPubSubType>([](auto seed) { return Draw(seed).judge_request(); }, as_message);
}
TEST(Wire, verdicts_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::VerdictPubSubType>([](auto seed) { return Draw(seed).verdict(); }, as_message);
}
TEST(Wire, goals_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::OptimizeGoalPubSubType>([](auto seed) { return Draw(seed).goal(); }, as_message);
}
TEST(Wire, results_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::OptimizedPrimitivePubSubType>([](auto seed) { return Draw(seed).result(); }, as_message);
}
TEST(Wire, experiences_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::ExperiencePubSubType>([](auto seed) { return Draw(seed).experience(); },
                                                   [](const symbols::Experience& e) { return to_wire(e, "batch"); });
}
TEST(Wire, rules_arrive_bit_for_bit_and_damaged_ones_are_refused) {
  round_trip_and_damage<msg::RuleSetPubSubType>(
      [](auto seed) { return Draw(seed).rule_set(); },
      [](const rules::RuleSet& r) { return to_wire(r, "batch", "*", 3, "digest"); });
}

TEST(Wire, what_is_sent_field_by_field_is_what_is_received) {
  // The bytes alone would not notice two fields exchanged on both ways.
  Draw draw(5);
  const motion::Primitive p = draw.primitive();
  const motion::Primitive q = from_wire(to_wire(p)).value();
  EXPECT_EQ(config::dump(p), config::dump(q));
  const scene::Scenario s = draw.scenario();
  EXPECT_EQ(config::dump(s), config::dump(from_wire(to_wire(s)).value()));
  const physics::JudgeSettings j = draw.judge_settings();
  EXPECT_EQ(config::dump(j), config::dump(from_wire(to_wire(j)).value()));
  const motion::Plan plan = draw.plan();
  const motion::Plan plan2 = from_wire(to_wire(plan)).value();
  EXPECT_EQ(plan.trajectory.q, plan2.trajectory.q);
  EXPECT_EQ(plan.gains.K, plan2.gains.K);
  EXPECT_EQ(plan.gains.k, plan2.gains.k);
  EXPECT_EQ(plan.cost_final, plan2.cost_final);
  EXPECT_EQ(plan.lambda, plan2.lambda);
  const physics::Verdict v = draw.verdict(), w = from_wire(to_wire(v)).value();
  EXPECT_EQ(v.before, w.before);
  EXPECT_EQ(v.after, w.after);
  EXPECT_EQ(v.clearance, w.clearance);
  EXPECT_EQ(v.target_clearance, w.target_clearance);
  EXPECT_EQ(v.limit_margin, w.limit_margin);
  EXPECT_EQ(v.survival, w.survival);
  ASSERT_EQ(v.contacts.size(), w.contacts.size());
  for (std::size_t i = 0; i < v.contacts.size(); ++i) {
    EXPECT_EQ(v.contacts[i].first, w.contacts[i].first);
    EXPECT_EQ(v.contacts[i].end, w.contacts[i].end);
    EXPECT_EQ(v.contacts[i].peak_force, w.contacts[i].peak_force);
  }
  ASSERT_EQ(v.survivals.size(), w.survivals.size());
  for (std::size_t i = 0; i < v.survivals.size(); ++i) {
    EXPECT_EQ(v.survivals[i].held, w.survivals[i].held);
    EXPECT_EQ(v.survivals[i].survival, w.survivals[i].survival);
    EXPECT_EQ(v.survivals[i].displacement, w.survivals[i].displacement);
  }
}

TEST(Wire, poses_are_not_rounded_by_the_way) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    scene::PointCloud cloud;
    cloud.X_WC = Draw(seed).pose_of();
    EXPECT_EQ(from_wire(to_wire(cloud)).value().X_WC.matrix(), cloud.X_WC.matrix());
  }
}

TEST(Wire, a_plan_request_takes_the_octree_along_only_where_a_task_needs_it) {
  motion::PlanRequest request = Draw(3).plan_request();
  request.scene.octree = {1, 2, 3};
  EXPECT_TRUE(to_wire(request).scene().octree().empty());
  request.primitive.tasks.emplace_back().variable = "perceived_collision";
  EXPECT_EQ(to_wire(request).scene().octree(), request.scene.octree);
}

TEST(Wire, a_plan_request_holds_one_object_at_most) {
  motion::PlanRequest request = Draw(4).plan_request();
  request.held = motion::HeldObject{"c1", Draw(5).pose_of()};
  msg::PlanRequest message = to_wire(request);
  const auto arrived = from_wire(message).value();
  ASSERT_TRUE(arrived.held);
  EXPECT_EQ(arrived.held->name, "c1");
  EXPECT_EQ(arrived.held->X_GO.matrix(), request.held->X_GO.matrix());
  message.held().push_back(message.held().front());
  EXPECT_EQ(from_wire(message).error().message, "malformed message: held has 2 entries, at most 1 are allowed");
  request.held.reset();
  EXPECT_FALSE(from_wire(to_wire(request)).value().held);
}

template <class Message, class Change>
std::string refusal(Message message, Change change) {
  change(message);
  const auto value = from_wire(message);
  return value.ok() ? "accepted" : value.error().message;
}

TEST(Wire, refusals_name_the_field_and_what_would_be_right) {
  Draw draw(1);
  const auto estimate = to_wire([&] {
    auto e = draw.estimate();
    e.objects.resize(1);
    e.objects[0].shape.size = {0.1, 0.1, 0.1};
    return e;
  }());
  EXPECT_EQ(refusal(estimate, [](auto& m) { m.objects()[0].type(9); }),
            "malformed message: estimate.objects.type is 9, expected less than 4");
  EXPECT_EQ(refusal(estimate, [](auto& m) { m.objects()[0].pose().rotation()[0] += 0.5; }),
            "malformed message: estimate.objects.pose has a matrix that is not a rotation");
  EXPECT_EQ(refusal(estimate, [](auto& m) { m.objects()[0].pose().position().x(kNaN); }),
            "malformed message: estimate.objects.pose is not finite");
  EXPECT_NE(refusal(estimate, [](auto& m) { m.table().thickness(7); }).find("estimate.table.thickness is 7"),
            std::string::npos);

  const auto request = to_wire(draw.judge_request());
  EXPECT_EQ(refusal(request, [](auto& m) { m.q().rows(1), m.q().cols(2), m.q().data().assign(3, 0.0); }),
            "malformed message: q is 1 × 2 but has 3 entries");
  EXPECT_EQ(refusal(request, [](auto& m) { m.q().rows(0x80000000u), m.q().cols(2), m.q().data().clear(); }),
            "malformed message: q is 2147483648 × 2 but has 0 entries");
  EXPECT_EQ(refusal(request, [](auto& m) { m.q().rows(1), m.q().cols(1), m.q().data().assign(1, kNaN); }),
            "malformed message: q is nan, expected a finite number");
  EXPECT_EQ(refusal(request, [](auto& m) { m.mode(2); }), "malformed message: mode is 2, expected less than 2");
  EXPECT_EQ(refusal(request, [](auto& m) { m.settings().max_joint_speed(51.5); }),
            "malformed message: settings.max_joint_speed is 51.500000, expected 0.1 to 50");

  auto goal = to_wire(draw.goal());
  goal.estimates().clear();
  goal.scenarios().assign(1, to_wire(draw.scenario()));
  EXPECT_EQ(from_wire(goal).error().message, "malformed message: goal has 1 scenarios but 0 estimates");

  msg::Literal literal;
  literal.predicate("size");
  literal.relation(4);
  EXPECT_EQ(from_wire(literal).error().message, "malformed message: literal has relation 4, expected less than 4");

  auto defined = to_wire(rules::RuleSet{}, "batch", "*", 0, "");
  defined.derived(std::vector<std::string>{"top(X) :="});
  EXPECT_NE(from_wire(defined).error().message.find("rule_set.derived"), std::string::npos);

  msg::RuleSet failed;
  failed.error("no experiences");
  EXPECT_EQ(from_wire(failed).error().code, Code::failed);
  EXPECT_EQ(from_wire(failed).error().message, "no experiences");
}

TEST(Wire, rules_carry_their_intervals_version_score_and_news) {
  const rules::Rule rule{.action = {"dry", {}},
                         .context = {},
                         .outcomes = {{0.94, {{"wet", {}, true}}, 47}},
                         .noise = 0.06,
                         .noise_count = 3,
                         .examples = 50};
  rules::RuleSet rules;
  rules.rules = {rule};
  auto message = to_wire(rules, "batch", "dry", 50, "digest");
  // Wilson's interval of 47/50 is 0.838 to 0.979, of 3/50 0.021 to 0.162.
  EXPECT_NEAR(message.rules()[0].outcomes()[0].lower(), 0.838, 5e-4);
  EXPECT_NEAR(message.rules()[0].outcomes()[0].upper(), 0.979, 5e-4);
  EXPECT_NEAR(message.rules()[0].noise_lower(), 0.021, 5e-4);
  EXPECT_NEAR(message.rules()[0].noise_upper(), 0.162, 5e-4);
  add_news({7, -12.5, rules::difference({}, rules)}, message);
  EXPECT_EQ(message.version(), 7u);
  EXPECT_EQ(message.score(), -12.5);
  EXPECT_EQ(message.added(), std::vector<std::string>{rules::to_text(rule)});
  EXPECT_TRUE(message.removed().empty() && message.changed().empty());
}

TEST(Ros, a_cloud_goes_through_pointcloud2_unchanged) {
  scene::PointCloud cloud = Draw(2).cloud();
  cloud.X_WC = Pose::Identity();
  const auto message = to_ros(cloud, "camera");
  EXPECT_EQ(message.header().frame_id(), "camera");
  const auto back = from_ros(message);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->points, cloud.points);
}

TEST(Ros, a_cloud_with_other_fields_padding_and_misses_is_read) {
  // Two rows of two points of 20 bytes: intensity, z, x, y, pad; rows padded to 48 bytes.
  sensor_msgs::msg::PointCloud2 message;
  const std::vector<std::pair<std::string, std::uint32_t>> fields = {{"intensity", 0}, {"z", 4}, {"x", 8}, {"y", 12}};
  for (const auto& [name, offset] : fields) {
    sensor_msgs::msg::PointField field;
    field.name(name);
    field.offset(offset);
    field.datatype(7);
    field.count(1);
    message.fields().push_back(field);
  }
  message.width(2);
  message.height(2);
  message.point_step(20);
  message.row_step(48);
  message.data().assign(96, 0xee);
  const auto put = [&](std::size_t at, float value) { std::memcpy(&message.data()[at], &value, 4); };
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t point = (i / 2) * 48 + (i % 2) * 20;
    put(point + 4, static_cast<float>(i) + 0.3f);
    put(point + 8, i == 2 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(i) + 0.1f);
    put(point + 12, static_cast<float>(i) + 0.2f);
  }
  const auto cloud = from_ros(message);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->points, (std::vector<Eigen::Vector3f>{{0.1f, 0.2f, 0.3f}, {1.1f, 1.2f, 1.3f}, {3.1f, 3.2f, 3.3f}}));
  message.row_step(50);
  EXPECT_FALSE(from_ros(message).ok());
  message.row_step(48);
  message.fields()[1].offset(17);
  EXPECT_FALSE(from_ros(message).ok());
}

TEST(Ros, damaged_clouds_are_read_or_refused) {
  const auto bytes = bytes_of<sensor_msgs::msg::PointCloud2PubSubType>(to_ros(Draw(4).cloud(), "camera"));
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Random random(seed, "damage");
    auto damaged = bytes;
    for (int i = 0; i < 3; ++i)
      damaged[4 + random.below(std::min<std::size_t>(160, damaged.size() - 4))] =
          static_cast<unsigned char>(random.bits());
    if (const auto message = message_of<sensor_msgs::msg::PointCloud2PubSubType>(damaged))
      (void)from_ros(*message).ok();
  }
}

TEST(Digest, does_not_depend_on_the_order_of_experiences_but_on_each_of_them) {
  EXPECT_EQ(experience_digest({"a", "b", "c"}), experience_digest({"c", "a", "b"}));
  EXPECT_NE(experience_digest({"a", "b"}), experience_digest({"a", "b", "c"}));
  EXPECT_NE(experience_digest({"ab", "c"}), experience_digest({"a", "bc"}));
}

}  // namespace
}  // namespace primo::wire

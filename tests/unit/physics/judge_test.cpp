#include "physics/judge.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <thread>

#include "grasp_fixture.h"
#include "physics/criteria.h"
#include "verdict_bytes.h"

namespace primo::physics {
namespace {

using testing::bytes;
using testing::hand_made_grasp;
using testing::HandMadeGrasp;
using testing::load_robot;
using testing::one_cylinder;
using testing::request_for;

/// One robot, judge and good grasp for all tests of this file.
struct World {
  robot::Robot robot = load_robot();
  Judge judge{robot};
  scene::Scenario scenario = one_cylinder();
  std::optional<HandMadeGrasp> good = hand_made_grasp(robot, scenario);
};
const World& world() {
  static const World instance;
  return instance;
}

Verdict judged(const JudgeRequest& request) {
  auto verdict = world().judge.evaluate(request);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  return std::move(verdict).value();
}

JudgeRequest good_request(std::uint64_t seed = 1) {
  PRIMO_CHECK(world().good.has_value(), "the fixture finds a grasp");
  return request_for(world().scenario, *world().good, seed);
}

TEST(Judge, a_good_grasp_is_held_and_changes_inhand_and_on) {
  int held = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Verdict v = judged(good_request(seed));
    held += v.success;
    EXPECT_TRUE(v.path_clean) << v.reason;
    if (!v.success) continue;
    EXPECT_EQ(v.outcome, Outcome::held);
    EXPECT_GT(v.score, 0.8);
    EXPECT_LT(v.position_error, 1e-3);
    symbols::State expected = v.before;
    expected.erase({"on", {"c1", "table"}});
    expected.insert({"inhand", {"c1"}});
    EXPECT_EQ(v.after, expected);
  }
  EXPECT_GE(held, 8);
}

TEST(Judge, a_hand_five_centimetres_short_touches_nothing) {
  const auto grasp = hand_made_grasp(world().robot, world().scenario, {0, 0, -0.06});
  ASSERT_TRUE(grasp.has_value());
  const Verdict v = judged(request_for(world().scenario, *grasp));
  EXPECT_FALSE(v.success);
  EXPECT_EQ(v.outcome, Outcome::no_contact);
  EXPECT_NEAR(v.score, 0.25 * std::exp(-v.position_error / 0.05), 1e-12);
  EXPECT_EQ(v.after, v.before);
}

TEST(Judge, a_grasp_at_the_objects_end_falls_in_the_jiggle) {
  const auto grasp = hand_made_grasp(world().robot, world().scenario, {0, 0.05, 0});
  const auto other = hand_made_grasp(world().robot, world().scenario, {0, -0.05, 0});
  ASSERT_TRUE(grasp || other);
  int held = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    held += judged(request_for(world().scenario, grasp ? *grasp : *other, seed)).success;
  EXPECT_LE(held, 1);
}

TEST(Judge, a_hand_inside_the_object_is_refused_before_the_simulation_and_graded_by_depth) {
  std::map<double, double> score_by_depth;
  for (const double offset : {0.03, 0.035, 0.04}) {
    const auto grasp = hand_made_grasp(world().robot, world().scenario, {-offset, 0, 0});
    ASSERT_TRUE(grasp.has_value());
    const Verdict v = judged(request_for(world().scenario, *grasp));
    ASSERT_EQ(v.outcome, Outcome::initial_penetration) << v.reason;
    EXPECT_EQ(v.steps, 0);
    EXPECT_FALSE(v.success);
    score_by_depth[offset] = v.score;
  }
  EXPECT_GT(score_by_depth[0.03], score_by_depth[0.04]);
}

TEST(Judge, sweeping_through_the_target_passes_the_final_pose_but_is_no_success) {
  // The trap of judging final poses alone: in from the side, fingers through the object, to the same good end.
  JudgeRequest request = good_request();
  const auto sweep = testing::sideways_sweep(world().robot, request.q.bottomRows(1).transpose());
  ASSERT_TRUE(sweep.has_value());
  testing::set_motion(request, *sweep);
  const Verdict v = judged(request);
  EXPECT_TRUE(v.final_pose_success) << v.reason;
  EXPECT_FALSE(v.path_clean);
  EXPECT_FALSE(v.success);
  EXPECT_LT(v.target_clearance, -0.006);
  EXPECT_FALSE(v.after.contains({"inhand", {"c1"}}));
  EXPECT_FALSE(v.after.contains({"upright", {"c1"}})) << "what the hand sweeps through falls over";
  EXPECT_TRUE(v.after.contains({"on", {"c1", "table"}}));
  request.mode = Mode::execute;
  const Verdict executed = judged(request);
  EXPECT_FALSE(executed.final_pose_success) << "physics agrees: " << executed.reason;
  EXPECT_FALSE(executed.success);
  EXPECT_FALSE(executed.after.contains({"inhand", {"c1"}}));
}

TEST(Judge, an_obstacle_in_the_way_makes_the_path_unclean_and_falls_over) {
  JudgeRequest request = good_request();
  const auto& robot = world().robot;
  // Where the palm comes to.
  const int palm = robot.body("palm");
  const Eigen::Vector3d p =
      robot.forward(request.q.bottomRows(1).transpose()).X_WB[static_cast<std::size_t>(palm)].translation();
  scene::Object obstacle = request.scenario.objects[0];
  obstacle.name = "o1";
  obstacle.position.x() = p.x();
  obstacle.position.y() = p.y() + 0.02;
  request.scenario.objects.push_back(obstacle);
  const Verdict v = judged(request);
  EXPECT_TRUE(v.final_pose_success);
  EXPECT_FALSE(v.success);
  EXPECT_LT(v.clearance, 0);
  EXPECT_NE(v.reason.find("o1"), std::string::npos) << v.reason;
  EXPECT_FALSE(v.after.contains({"upright", {"o1"}}));
  EXPECT_FALSE(v.after.contains({"inhand", {"c1"}}));
}

TEST(Judge, a_motion_that_is_too_fast_is_refused_and_changes_nothing) {
  JudgeRequest request = good_request();
  const double speed = judged(request).max_speed;
  request.dt *= 0.9 * speed / request.settings.max_joint_speed;
  const Verdict v = judged(request);
  EXPECT_NEAR(v.max_speed, request.settings.max_joint_speed / 0.9, 1e-9);
  EXPECT_FALSE(v.success);
  EXPECT_TRUE(v.final_pose_success);
  EXPECT_EQ(v.after, v.before);
}

TEST(Judge, a_joint_beyond_its_limits_is_refused_by_name_in_both_modes) {
  JudgeRequest request = good_request();
  const auto& robot = world().robot;
  request.q(10, 3) = robot.upper()[3] + 0.05;
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    request.mode = mode;
    const Verdict v = judged(request);
    EXPECT_FALSE(v.success);
    EXPECT_FALSE(v.path_clean);
    EXPECT_NEAR(v.limit_margin, -0.05, 1e-9);
    EXPECT_NE(v.reason.find("joint " + robot.joint_names()[3]), std::string::npos) << v.reason;
    EXPECT_NE(v.reason.find("step 10"), std::string::npos) << v.reason;
  }
}

TEST(Judge, a_verdict_depends_on_its_request_alone_in_any_order_and_thread) {
  std::vector<JudgeRequest> requests;
  for (std::uint64_t seed = 0; seed < 3; ++seed) requests.push_back(good_request(seed));
  for (const double offset : {0.02, -0.05}) {
    if (const auto grasp = hand_made_grasp(world().robot, world().scenario, {0, 0, offset})) {
      requests.push_back(request_for(world().scenario, *grasp));
    }
  }
  requests.push_back(good_request(9));
  requests.back().scenario.objects[0].radius = 0.034;  // another model in the cache
  requests.push_back(good_request(9));
  requests.back().mode = Mode::execute;
  std::vector<std::string> expected;
  for (const auto& request : requests) {
    const Judge fresh{load_robot()};
    auto verdict = fresh.evaluate(request);
    ASSERT_TRUE(verdict.ok()) << verdict.error().message;
    expected.push_back(bytes(*verdict));
  }
  std::vector<std::vector<std::string>> found(2, std::vector<std::string>(3 * requests.size()));
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < 2; ++thread) {
    threads.emplace_back([&, thread] {
      for (std::size_t k = 0; k < found[thread].size(); ++k) {
        const std::size_t i = (thread == 0 ? k * 5 : k * 3 + 1) % requests.size();
        auto verdict = world().judge.evaluate(requests[i]);
        found[thread][k] =
            verdict.ok() && bytes(*verdict) == expected[i] ? "same" : "request " + std::to_string(i) + " differs";
      }
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& list : found) {
    for (const auto& text : list) EXPECT_EQ(text, "same");
  }
}

TEST(Judge, a_good_grasp_is_lifted_when_executed_in_full_physics) {
  JudgeRequest request = good_request();
  request.mode = Mode::execute;
  const Verdict v = judged(request);
  EXPECT_TRUE(v.success) << v.reason;
  EXPECT_TRUE(v.after.contains({"inhand", {"c1"}}));
  EXPECT_FALSE(v.after.contains({"on", {"c1", "table"}}));
}

TEST(Judge, executing_a_miss_leaves_the_object_on_the_table) {
  const auto grasp = hand_made_grasp(world().robot, world().scenario, {0, 0, -0.06});
  ASSERT_TRUE(grasp.has_value());
  JudgeRequest request = request_for(world().scenario, *grasp);
  request.mode = Mode::execute;
  const Verdict v = judged(request);
  EXPECT_FALSE(v.success);
  EXPECT_EQ(v.outcome, Outcome::no_contact);
  EXPECT_EQ(v.after, v.before);
}

TEST(Judge, execution_with_wild_gains_is_never_a_success) {
  JudgeRequest request = good_request();
  request.mode = Mode::execute;
  const auto n = request.q.cols();
  // Feedback that pushes away from the plan with all the motors have.
  request.K.assign(static_cast<std::size_t>(request.q.rows() - 1), Eigen::MatrixXd::Constant(n, 2 * n, 1e12));
  const Verdict v = judged(request);
  EXPECT_FALSE(v.success);
  EXPECT_TRUE(std::isfinite(v.score) && std::isfinite(v.displacement));
}

TEST(Judge, a_plan_that_starts_elsewhere_or_absurdly_is_a_bad_plan) {
  JudgeRequest request = good_request();
  request.scenario.robot_start[0] += 0.1;
  Verdict v = judged(request);
  EXPECT_EQ(v.outcome, Outcome::bad_plan);
  EXPECT_FALSE(v.success);
  EXPECT_EQ(v.after, v.before);
  request = good_request();
  request.q(5, 2) = 1e30;
  v = judged(request);
  EXPECT_EQ(v.outcome, Outcome::bad_plan);
  EXPECT_FALSE(v.success);
}

TEST(Judge, malformed_requests_are_errors_that_name_what_is_wrong) {
  const auto error = [](const JudgeRequest& request) {
    const auto verdict = world().judge.evaluate(request);
    if (verdict.ok()) return std::string("accepted");
    EXPECT_EQ(verdict.error().code, Code::data) << verdict.error().message;
    return verdict.error().message;
  };
  const auto with = [&](auto change) {
    JudgeRequest request = good_request();
    change(request);
    return error(request);
  };
  EXPECT_NE(with([](auto& r) { r.q.conservativeResize(r.q.rows(), 13); }).find("13 columns"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.q.conservativeResize(1, r.q.cols()); }).find("1 rows"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.q(3, 3) = std::numeric_limits<double>::quiet_NaN(); }).find("not finite"),
            std::string::npos);
  EXPECT_NE(with([](auto& r) { r.dt = 0; }).find("dt"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.dt = std::numeric_limits<double>::infinity(); }).find("dt"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.K.resize(3); }).find("3 gains"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.settings.timestep = 0; }).find("timestep"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.settings.jiggle_frequency = std::nan(""); }).find("jiggle_frequency"),
            std::string::npos);
  EXPECT_NE(with([](auto& r) { r.scenario.action = {"grasp", "c7"}; }).find("c7"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.scenario.action = {"throw", "c1"}; }).find("throw"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.scenario.robot_start.resize(3); }).find("robot_start"), std::string::npos);
  EXPECT_NE(with([](auto& r) { r.settings.survival_seeds = -1; }).find("survival_seeds"), std::string::npos);
  EXPECT_NE(with([](auto& r) {
              r.settings.survival_amplitudes = {1, -2};
            }).find("survival_amplitudes"),
            std::string::npos);
  EXPECT_NE(with([](auto& r) { r.settings.survival_amplitudes.assign(21, 1); }).find("more than 20"),
            std::string::npos);
  EXPECT_NE(with([](auto& r) {
              r.scenario.objects.push_back(r.scenario.objects[0]);
              r.scenario.objects.back().name = "c2";
            }).find("c2"),
            std::string::npos);
}

TEST(Criteria, clearance_over_a_path_is_that_of_its_densest_sampling) {
  const auto& robot = world().robot;
  const auto scenario = world().scenario;
  ClearanceQuery query(robot, clearance_pairs(scenario, "none"));
  for (std::uint64_t k = 0; k < 12; ++k) {
    Random random(k, "paths");
    Eigen::MatrixXd q(4, robot.joints());
    for (Eigen::Index t = 0; t < q.rows(); ++t) {
      for (int i = 0; i < robot.joints(); ++i) q(t, i) = random.uniform(robot.lower()[i], robot.upper()[i]);
    }
    double sampled = ClearanceQuery::kFar;
    for (Eigen::Index t = 0; t + 1 < q.rows(); ++t) {
      for (int s = 0; s <= 400; ++s)
        sampled = std::min(sampled, query.at(((1 - s / 400.0) * q.row(t) + s / 400.0 * q.row(t + 1)).transpose()));
    }
    const double found = query.over(q);
    if (found <= ClearanceQuery::kDeep) {
      EXPECT_LE(sampled, ClearanceQuery::kDeep + 0.02);
    } else {
      EXPECT_LE(found, sampled + ClearanceQuery::kTolerance) << "path " << k;
      EXPECT_GE(found, sampled - 0.015) << "path " << k;  // what 400 samples a step may miss
    }
  }
}

TEST(Criteria, no_point_of_the_robot_moves_further_than_the_motion_bound) {
  const auto& robot = world().robot;
  ClearanceQuery query(robot, {});
  for (std::uint64_t k = 0; k < 200; ++k) {
    Random random(k, "motion");
    Eigen::VectorXd a(robot.joints()), b(robot.joints());
    for (int i = 0; i < robot.joints(); ++i) {
      a[i] = random.uniform(robot.lower()[i], robot.upper()[i]);
      b[i] = std::clamp(a[i] + 0.3 * random.normal(), robot.lower()[i], robot.upper()[i]);
    }
    const auto at_a = robot.forward(a), at_b = robot.forward(b);
    for (const auto& link : robot.link_shapes()) {
      const Eigen::Vector3d end(0, 0, link.shape.size.y() + link.shape.size.x());
      EXPECT_LE((robot.pose(at_a, link) * end - robot.pose(at_b, link) * end).norm(), query.motion_bound(a, b) + 1e-12);
    }
  }
}

TEST(Criteria, the_table_names_every_criterion_once_and_in_the_verdicts_order) {
  const Verdict v = judged(good_request());
  ASSERT_EQ(v.criteria.size(), criteria().size());
  for (std::size_t i = 0; i < v.criteria.size(); ++i) EXPECT_EQ(v.criteria[i].name, criteria()[i].name);
  EXPECT_EQ(v.clearance, v.criteria[0].value);
  EXPECT_EQ(v.target_clearance, v.criteria[1].value);
}

}  // namespace
}  // namespace primo::physics

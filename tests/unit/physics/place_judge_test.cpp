#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>
#include <numbers>

#include "grasp_fixture.h"
#include "physics/criteria.h"
#include "physics/depth_camera.h"
#include "physics/place_end.h"
#include "place_fixture.h"
#include "robot/distance.h"
#include "scene/perception.h"
#include "scene/reach.h"

namespace primo::physics {
namespace {

using testing::place_at;

struct World {
  robot::Robot robot = testing::load_robot();
  Judge judge{robot};
  std::optional<JudgeRequest> good = place_at(robot, {0, 0, 0});
};
const World& world() {
  static const World instance;
  return instance;
}

JudgeRequest good_request() {
  PRIMO_CHECK(world().good.has_value(), "the fixture finds a place");
  return *world().good;
}

JudgeRequest request_at(const Eigen::Vector3d& offset) {
  const auto request = place_at(world().robot, offset);
  PRIMO_CHECK(request.has_value(), "the fixture finds this place");
  return *request;
}

Verdict judged(const JudgeRequest& request) {
  auto verdict = world().judge.evaluate(request);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  return std::move(verdict).value();
}

const Criterion& criterion(const Verdict& verdict, const std::string& name) {
  for (const auto& c : verdict.criteria) {
    if (c.name == name) return c;
  }
  PRIMO_CHECK(false, "the verdict has criterion " + name);
  return verdict.criteria.front();
}

bool holds(const symbols::State& state, const std::string& predicate, const std::vector<std::string>& arguments) {
  return state.contains({predicate, arguments});
}

/// All that a verdict says, bit for bit.
std::string bytes(const Verdict& v) {
  std::string text = std::to_string(v.success) + config::enum_name(v.outcome) + v.reason + std::to_string(v.steps);
  const auto add = [&](double value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const double value : {v.score, v.displacement, v.position_error, v.clearance, v.target_clearance}) add(value);
  for (const auto& c : v.criteria) text += c.name, add(c.value);
  for (const auto& literal : v.after) text += literal.text();
  return text;
}

TEST(PlaceJudge, an_object_set_on_its_support_is_on_it_and_out_of_the_hand) {
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    JudgeRequest request = good_request();
    request.mode = mode;
    const Verdict v = judged(request);
    EXPECT_TRUE(v.success) << v.reason;
    EXPECT_EQ(v.outcome, Outcome::placed);
    EXPECT_TRUE(holds(v.before, "inhand", {"c1"}));
    EXPECT_FALSE(holds(v.before, "on", {"c1", "c2"}));
    EXPECT_TRUE(holds(v.after, "on", {"c1", "c2"}));
    EXPECT_TRUE(holds(v.after, "on", {"c2", "table"}));
    EXPECT_TRUE(holds(v.after, "upright", {"c1"}));
    EXPECT_FALSE(holds(v.after, "inhand", {"c1"}));
    EXPECT_TRUE(criterion(v, "on").met && criterion(v, "on_paper").met);
    EXPECT_LT(criterion(v, "place_offset").value, 0.02);
    EXPECT_GT(v.score, 0.8);
  }
}

TEST(PlaceJudge, the_arm_stands_still_while_the_hand_opens) {
  const auto& robot = world().robot;
  JudgeRequest request = good_request();
  request.mode = Mode::execute;
  Recording recording;
  recording.interval = 0.02;
  ASSERT_TRUE(world().judge.evaluate(request, &recording).ok());
  const Eigen::VectorXd end = request.q.bottomRows(1).transpose();
  const int thumb = robot.arm_joints() + 1;
  const Eigen::Vector3d planned = robot.pose(robot.forward(end), robot.grasp_frame()).translation();
  const double held = recording.frames[recording.frames.size() / 2].q[thumb];  // on the way
  int opening = 0;
  for (const auto& frame : recording.frames) {
    // Neither closed on the object nor quite open yet.
    const double open = (frame.q[thumb] - held) / (robot.home()[thumb] - held);
    if (frame.time < 1 || open < 0.2 || open > 0.95) continue;
    ++opening;
    const Eigen::Vector3d at = robot.pose(robot.forward(frame.q), robot.grasp_frame()).translation();
    EXPECT_LT((at - planned).norm(), 1.5e-3) << "at " << frame.time << " s";
  }
  EXPECT_GT(opening, 3);
}

TEST(PlaceJudge, it_tips_when_its_centre_is_beyond_the_supports_rim_whatever_the_papers_criterion_says) {
  // Cylinders of radius 37.5 mm: a centre of mass 28 mm off is over the support, one 50 mm off is not.
  const double radius = good_request().scenario.object("c2")->radius;
  ASSERT_GT(radius, 0.028);
  ASSERT_LT(radius, 0.05);
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0)}) {
    const Verdict off = judged(request_at(0.05 * direction));
    EXPECT_TRUE(criterion(off, "on_paper").met);
    EXPECT_FALSE(criterion(off, "on").met);
    EXPECT_FALSE(off.final_pose_success) << off.reason;
    EXPECT_FALSE(holds(off.after, "on", {"c1", "c2"}));
    EXPECT_FALSE(holds(off.after, "inhand", {"c1"}));
    const Verdict over = judged(request_at(0.02 * direction));
    EXPECT_TRUE(criterion(over, "on").met) << over.reason;
    EXPECT_NEAR(over.position_error, std::hypot(0.02, 0.005), 1e-3);
    EXPECT_GT(over.score, off.score);
  }
}

TEST(PlaceJudge, the_papers_criterion_can_be_chosen) {
  JudgeRequest request = request_at({0.05, 0, 0});
  request.settings.place_criterion = PlaceCriterion::paper;
  const Verdict v = judged(request);
  EXPECT_TRUE(v.final_pose_success) << v.reason;
  EXPECT_TRUE(holds(v.after, "on", {"c1", "c2"}));
  EXPECT_FALSE(criterion(v, "on").met);
  request = request_at({0, 0, 0.1});
  request.settings.place_criterion = PlaceCriterion::paper;
  EXPECT_FALSE(judged(request).final_pose_success);
}

TEST(PlaceJudge, let_go_too_high_is_no_place_by_the_paper_and_scores_less_the_higher_it_is) {
  std::vector<double> scores;
  for (const double height : {0.03, 0.06, 0.12}) {
    JudgeRequest request = request_at({0.045, 0, height});
    const Verdict v = judged(request);
    EXPECT_FALSE(criterion(v, "on_paper").met);
    EXPECT_FALSE(v.success) << v.reason;
    scores.push_back(v.score);
  }
  EXPECT_GT(scores[0], scores[1]);
  EXPECT_GT(scores[1], scores[2]);
}

TEST(PlaceJudge, a_final_pose_deep_in_the_support_is_refused_before_the_simulation) {
  const Verdict v = judged(request_at({0, 0, -0.015}));
  EXPECT_EQ(v.outcome, Outcome::initial_penetration) << v.reason;
  EXPECT_EQ(v.steps, 0);
  EXPECT_FALSE(v.success);
  const Verdict deeper = judged(request_at({0, 0, -0.03}));
  EXPECT_GT(v.score, deeper.score);
}

TEST(PlaceJudge, a_hand_that_cannot_open_takes_the_object_along) {
  // The same robot, but what its file calls open is closed: the fingers stay where they press.
  const auto source = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots/schunk_lwa3_sdh2.yaml";
  auto file = config::read<robot::RobotFile>(source);
  ASSERT_TRUE(file.ok());
  file->mjcf = (source.parent_path() / file->mjcf).string();
  for (auto& joint : file->hand) {
    if (joint.closing != 0) joint.home = 0.8;
  }
  const auto path = std::filesystem::temp_directory_path() / ("primo_clenched_" + std::to_string(::getpid()) + ".yaml");
  ASSERT_TRUE(write_file(path, config::dump(*file)).ok());
  auto clenched = robot::Robot::load(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(clenched.ok()) << clenched.error().message;
  const Judge judge(*clenched);
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    JudgeRequest request = good_request();
    request.mode = mode;
    const auto v = judge.evaluate(request);
    ASSERT_TRUE(v.ok()) << v.error().message;
    EXPECT_FALSE(v->final_pose_success) << v->reason;
    EXPECT_EQ(v->outcome, Outcome::not_released) << v->reason;
    EXPECT_FALSE(criterion(*v, "place_off_hand").met);
    EXPECT_FALSE(holds(v->after, "on", {"c1", "c2"}));
  }
}

TEST(PlaceJudge, a_path_through_the_support_is_no_success_and_knocks_it_over) {
  // Straight across at half the support's height, then up to the good end: the final pose alone would not tell.
  JudgeRequest request = good_request();
  const auto& scenario = request.scenario;
  const Eigen::Vector3d from = scenario.object("c1")->position, support = scenario.object("c2")->position;
  const Eigen::Vector3d end = testing::top_of_support(scenario) + Eigen::Vector3d(0, 0, 0.005);
  const Eigen::Vector3d beyond = support + 0.3 * (support - from) + Eigen::Vector3d(0, 0, 0.03);
  const auto path =
      testing::carry(world().robot, scenario,
                     {beyond, {beyond.x(), beyond.y(), end.z() + 0.06}, {end.x(), end.y(), end.z() + 0.06}, end});
  ASSERT_TRUE(path.has_value());
  request.q = *path;
  const Verdict v = judged(request);
  EXPECT_TRUE(v.final_pose_success) << v.reason;
  EXPECT_FALSE(v.path_clean);
  EXPECT_FALSE(v.success);
  EXPECT_LT(v.target_clearance, -0.01);
  EXPECT_FALSE(holds(v.after, "upright", {"c2"}));
  EXPECT_TRUE(holds(v.after, "inhand", {"c1"}));
  request.mode = Mode::execute;
  const Verdict executed = judged(request);
  EXPECT_FALSE(executed.success);
  EXPECT_FALSE(holds(executed.after, "on", {"c1", "c2"})) << executed.reason;
}

TEST(PlaceJudge, an_obstacle_that_the_held_object_sweeps_through_makes_the_path_unclean) {
  JudgeRequest request = good_request();
  const Eigen::Index middle = request.q.rows() / 2;
  const auto& robot = world().robot;
  const Pose X_WX =
      robot.pose(robot.forward(request.q.row(middle).transpose()), robot.grasp_frame()) * request.scenario.held->X_GO();
  scene::Object wall;
  wall.name = "b1";
  wall.type = ShapeType::box;
  wall.half_extents = {0.012, 0.012, (X_WX.translation().z() - 0.67) / 2};
  wall.position = {X_WX.translation().x(), X_WX.translation().y(), 0.67 + wall.half_extents.z()};
  request.scenario.objects.push_back(wall);
  if (const auto status = request.scenario.validate(); !status.ok()) GTEST_SKIP() << status.error().message;
  const Verdict v = judged(request);
  EXPECT_LT(v.clearance, 0);
  EXPECT_FALSE(v.success);
  EXPECT_NE(v.reason.find("b1"), std::string::npos) << v.reason;
  EXPECT_TRUE(holds(v.after, "inhand", {"c1"}));
}

TEST(PlaceJudge, the_plans_fingers_are_not_followed_while_the_hand_holds) {
  JudgeRequest request = good_request();
  const std::string as_planned = bytes(judged(request));
  for (Eigen::Index t = 1; t < request.q.rows(); ++t) request.q.row(t).tail(7).setConstant(-0.5);
  EXPECT_EQ(bytes(judged(request)), as_planned);
}

TEST(PlaceJudge, a_verdict_depends_on_its_request_alone) {
  std::vector<JudgeRequest> requests = {good_request(), request_at({0.05, 0, 0}), request_at({0, 0.02, 0}),
                                        good_request(), good_request()};
  requests[3].mode = Mode::execute;
  requests[4].settings.timestep = 0.001;
  std::vector<std::string> expected;
  for (const auto& request : requests) {
    const Judge fresh{testing::load_robot()};
    auto verdict = fresh.evaluate(request);
    ASSERT_TRUE(verdict.ok()) << verdict.error().message;
    expected.push_back(bytes(*verdict));
  }
  for (std::size_t k = 0; k < 3 * requests.size(); ++k) {
    const std::size_t i = (k * 3 + 1) % requests.size();
    EXPECT_EQ(bytes(judged(requests[i])), expected[i]) << "request " << i << " at turn " << k;
  }
}

TEST(PlaceJudge, malformed_requests_are_errors_that_name_what_is_wrong) {
  const auto with = [&](auto change) {
    JudgeRequest request = good_request();
    change(request);
    const auto verdict = world().judge.evaluate(request);
    return verdict.ok() ? std::string("accepted") : verdict.error().message;
  };
  const auto says = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? ::testing::AssertionSuccess() : ::testing::AssertionFailure() << text;
  };
  EXPECT_TRUE(says(with([](auto& r) { r.q(3, 3) = std::numeric_limits<double>::quiet_NaN(); }), "not finite"));
  EXPECT_TRUE(says(with([](auto& r) { r.q.conservativeResize(r.q.rows(), 9); }), "9 columns"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.held.reset(); }), "c1"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.held->object = "c2"; }), "c1"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.action = {"place", "c1"}; }), "must have two"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.action = {"place", "c1", "c1"}; }), "on itself"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.action = {"grasp", "c2"}; }), "free hand"));
  // Five centimetres off where robot_start and X_GO put it.
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.objects[0].position.z() += 0.05; }), "50.0 mm"));
  // Consistent, but not between the fingers.
  EXPECT_TRUE(says(with([](auto& r) {
                     r.scenario.held->position.z() += 0.25;
                     const Pose X =
                         testing::load_robot().pose(testing::load_robot().forward(testing::start_of(r.scenario)),
                                                    testing::load_robot().grasp_frame()) *
                         r.scenario.held->X_GO();
                     r.scenario.objects[0].position = X.translation();
                   }),
                   "not in the hand"));
  EXPECT_TRUE(says(with([](auto& r) { r.scenario.robot_start.clear(); }), "robot_start"));
}

TEST(PlaceScenes, are_reproducible_and_hold_their_object_with_margins) {
  const auto& robot = world().robot;
  for (std::uint64_t index = 0; index < 3; ++index) {
    const auto scenario = random_place_scenario(robot, {}, 21, index);
    ASSERT_TRUE(scenario.ok()) << scenario.error().message;
    EXPECT_EQ(config::dump(*scenario), config::dump(*random_place_scenario(robot, {}, 21, index)));
    EXPECT_TRUE(scenario->validate().ok());
    EXPECT_TRUE(scene::check_robot(*scenario, robot).ok());
    EXPECT_EQ(scenario->action, (std::vector<std::string>{"place", "c1", "c2"}));
    ClearanceQuery query(robot, clearance_pairs(*scenario, "c1"), held_shape(robot, *scenario));
    EXPECT_GE(query.at(testing::start_of(*scenario)), PlaceSceneSettings{}.min_gap - 1e-9);
  }
}

TEST(PlaceScenes, displaced_objects_do_not_lie_in_what_the_hand_holds_nor_in_the_hand) {
  const auto& robot = world().robot;
  scene::Scenario base = testing::place_scenario(robot);
  const robot::Kinematics start = robot.forward(testing::start_of(base));
  const scene::Object& held = *base.object("c1");
  // A tall post beside the hand, near enough that many draws put it into the hand.
  scene::Object post = held;
  post.name = "o1";
  post.radius = 0.01;
  post.height = 0.3;
  const Eigen::Vector3d centre = base.table.top_centre;
  post.position = held.position + 0.1 * (centre - held.position).cwiseProduct(Eigen::Vector3d(1, 1, 0)).normalized();
  post.position.z() = centre.z() + 0.15;
  post.rpy.setZero();
  base.objects.push_back(post);
  const auto depth = [&](const scene::Scenario& scenario) {
    const auto& moved = *scenario.object("o1");
    double least = robot::distance(held.shape(), held.X_WO(), moved.shape(), moved.X_WO()).distance;
    for (const auto& link : robot.link_shapes())
      least =
          std::min(least, robot::distance(link.shape, robot.pose(start, link), moved.shape(), moved.X_WO()).distance);
    return least;
  };
  int rejected = 0, in_robot = 0, same = 0;
  constexpr int kDraws = 60;
  for (std::uint64_t index = 0; index < kDraws; ++index) {
    const auto moved = scene::displace(robot, base, 0.1, 3, index);
    ASSERT_TRUE(moved.ok()) << moved.error().message;
    EXPECT_GE(depth(moved->scenario), 0) << index;
    rejected += moved->rejected_in_robot > 0;
    const auto without = scene::displace(base, 0.1, 3, index);
    ASSERT_TRUE(without.ok());
    in_robot += depth(without->scenario) < 0;
    same += config::dump(without->scenario) == config::dump(moved->scenario);
  }
  EXPECT_GT(in_robot, 5) << "the rule makes a difference here";
  EXPECT_EQ(rejected, in_robot);
  EXPECT_EQ(same, kDraws - in_robot) << "other draws are what they were";
}

TEST(PlaceScenes, cameras_do_not_see_what_the_hand_holds_and_perception_takes_it_from_the_hand) {
  const scene::Scenario scenario = good_request().scenario;
  const auto clouds = render_depth(scenario);
  ASSERT_TRUE(clouds.ok());
  const scene::Object& held = *scenario.object("c1");
  for (const auto& cloud : *clouds) {
    for (const auto& p_C : cloud.points) {
      Eigen::Vector3d normal;
      const Eigen::Vector3d p_O = held.X_WO().inverse(Eigen::Isometry) * (cloud.X_WC * p_C.cast<double>());
      ASSERT_GT(robot::signed_distance(held.shape(), p_O, normal), 0.002);
    }
  }
  const auto estimate = scene::perceive(scene::perception_request(scenario, *clouds));
  ASSERT_TRUE(estimate.ok()) << estimate.error().message;
  ASSERT_EQ(estimate->objects.size(), 2U);
  EXPECT_EQ(estimate->objects[0].name, "c1");
  EXPECT_EQ(estimate->objects[0].X_WO.matrix(), held.X_WO().matrix());
  EXPECT_LT((estimate->objects[1].X_WO.translation() - scenario.object("c2")->position).norm(), 0.005);
}

TEST(PlaceEnd, stacking_is_what_the_geometry_says) {
  const scene::Scenario scenario = good_request().scenario;
  const Pose X_WY = scenario.object("c2")->X_WO();
  Pose X_WX = pose(testing::top_of_support(scenario) + Eigen::Vector3d(0.003, -0.004, 0.007));
  Stacking s = stacking(scenario, X_WX, X_WY);
  EXPECT_NEAR(s.offset, 0.005, 1e-12);
  EXPECT_NEAR(s.height, 0.007, 1e-12);
  EXPECT_NEAR(s.tilt, 0, 1e-7);
  EXPECT_EQ(s.overlap, 0);
  X_WX.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_NEAR(stacking(scenario, X_WX, X_WY).tilt, 0.4, 1e-12);
  X_WX.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()).toRotationMatrix();
  X_WX.translation().z() -= 0.010;
  s = stacking(scenario, X_WX, X_WY);
  EXPECT_NEAR(s.tilt, 0, 1e-7) << "a cylinder on its head stands too";
  EXPECT_NEAR(s.overlap, 0.003, 1e-4);
  scene::Scenario on_table = scenario;
  on_table.action = {"place", "c1", "table"};
  const Eigen::Vector3d p(0.9, 0.3, 0.67 + 0.054);
  s = stacking(on_table, pose(p), support_pose(on_table));
  EXPECT_NEAR(s.height, 0, 1e-12);
  EXPECT_NEAR(s.offset, 0.3 - 0.26, 1e-12) << "beyond the table's edge";
}

TEST(PlaceEnd, the_score_falls_smoothly_with_offset_height_tilt_and_depth_and_stays_below_a_place) {
  const JudgeSettings settings;
  const auto at = [&](double offset, double height, double tilt, double overlap) {
    return place_score({offset, height, tilt, overlap}, settings);
  };
  EXPECT_LE(at(0, 0, 0, 0), 0.7);
  const double step = 1e-4;
  for (double x = 0; x < 0.2; x += step) {
    EXPECT_GT(at(x, 0, 0, 0), at(x + step, 0, 0, 0));
    EXPECT_GT(at(0, x, 0, 0), at(0, x + step, 0, 0));
    EXPECT_GT(at(0, 0, x, 0), at(0, 0, x + step, 0));
    EXPECT_GE(at(0, 0, 0, x), at(0, 0, 0, x + step));
    // No steps: a tenth of a millimetre changes no more than the steepest slope allows, 0.7 / 0.01 a metre.
    EXPECT_LT(at(x, 0, 0, x) - at(x + step, 0, 0, x + step), 0.7 * step * (1 / 0.05 + 1 / 0.01));
  }
  PlaceEnd end;
  end.touches_support = true;
  EXPECT_EQ(decide_place(end, settings).outcome, Outcome::placed);
  EXPECT_NEAR(decide_place(end, settings).score, 1.0, 1e-12);
  end.found.offset = settings.place_offset;
  EXPECT_NEAR(decide_place(end, settings).score, 0.8, 1e-12);
}

TEST(PlaceEnd, each_criterion_alone_refuses) {
  const JudgeSettings settings;
  PlaceEnd good;
  good.touches_support = true;
  ASSERT_EQ(decide_place(good, settings).outcome, Outcome::placed);
  const auto outcome = [&](auto change) {
    PlaceEnd end = good;
    change(end);
    return decide_place(end, settings).outcome;
  };
  EXPECT_EQ(outcome([](auto& e) { e.found.height = -0.011; }), Outcome::not_on);
  EXPECT_EQ(outcome([](auto& e) { e.found.offset = 0.031; }), Outcome::not_on);
  EXPECT_EQ(outcome([](auto& e) { e.found.tilt = 0.11; }), Outcome::not_on);
  EXPECT_EQ(outcome([](auto& e) { e.speed = 0.03; }), Outcome::not_on);
  EXPECT_EQ(outcome([](auto& e) { e.touches_support = false; }), Outcome::not_on);
  EXPECT_EQ(outcome([](auto& e) { e.touches_hand = true; }), Outcome::not_released);
  EXPECT_EQ(outcome([](auto& e) { e.support_tilt = 1.5; }), Outcome::support_fell);
}

TEST(PlaceEnd, the_hand_opens_from_what_it_holds_to_its_home) {
  const auto& robot = world().robot;
  const Eigen::VectorXd holding = Eigen::VectorXd::Constant(7, 0.3), open = robot.home().tail(7);
  EXPECT_EQ(opening_targets(robot, holding, 0), holding);
  const Eigen::VectorXd end = opening_targets(robot, holding, kOpenSeconds);
  EXPECT_EQ(end[0], 0.3) << "the knuckle does not close, so it does not open";
  for (int i = 1; i < 7; ++i) EXPECT_NEAR(end[i], open[i], 1e-12);
  EXPECT_EQ(opening_targets(robot, holding, 99), end);
}

}  // namespace
}  // namespace primo::physics

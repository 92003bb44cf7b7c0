// The whole motion in full physics: what it says about contacts, neighbours and simulations that diverge.
#include "physics/execution.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/files.h"
#include "grasp_fixture.h"
#include "verdict_bytes.h"

namespace primo::physics {
namespace {

using testing::hand_made_grasp;
using testing::request_for;

struct World {
  robot::Robot robot = testing::load_robot();
  Judge judge{robot};
  scene::Scenario scenario = testing::one_cylinder();
  std::optional<testing::HandMadeGrasp> good = hand_made_grasp(robot, scenario);
};
const World& world() {
  static const World instance;
  return instance;
}

JudgeRequest good_request(Mode mode) {
  PRIMO_CHECK(world().good.has_value(), "the fixture finds a grasp");
  JudgeRequest request = request_for(world().scenario, *world().good);
  request.mode = mode;
  return request;
}

Verdict judged(const JudgeRequest& request, Recording* recording = nullptr) {
  auto verdict = world().judge.evaluate(request, recording);
  PRIMO_CHECK(verdict.ok(), verdict.error().message);
  return std::move(verdict).value();
}

const Contact* contact(const Verdict& verdict, const std::string& a, const std::string& b) {
  for (const auto& pair : verdict.contacts) {
    if (pair.first == a && pair.second == b) return &pair;
  }
  return nullptr;
}

bool from_the_robot(const Contact& pair) { return world().robot.body(pair.first) >= 0; }

TEST(ContactLog, measures_the_weight_of_what_stands) {
  auto scenario = testing::one_cylinder();
  scenario.objects[0].mass = 0.7;
  auto model = assemble(nullptr, scenario);
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  for (int k = 0; k < 500; ++k) mj_step(model->get(), data.get());
  ContactLog log(model->get());
  for (int k = 0; k < 100; ++k) {
    mj_step(model->get(), data.get());
    log.record(model->get(), data.get(), 0.002 * k);
  }
  ASSERT_EQ(log.contacts().size(), 1U);
  const Contact& stands = log.contacts()[0];
  EXPECT_EQ(std::min(stands.first, stands.second), "c1");
  EXPECT_EQ(std::max(stands.first, stands.second), "table");
  EXPECT_EQ(stands.begin, 0);
  EXPECT_NEAR(stands.end, 0.198, 1e-12);
  EXPECT_NEAR(stands.peak_force, 0.7 * 9.81, 0.02);
}

TEST(ContactLog, is_bounded_and_counts_what_it_leaves_out) {
  constexpr int kBodies = Verdict::kMostContacts + 12;
  std::string mjcf =
      "<mujoco><size njmax=\"4000\" nconmax=\"1000\"/><worldbody><geom name=\"floor\" type=\"plane\" size=\"9 9 1\"/>";
  for (int i = 0; i < kBodies; ++i) {
    mjcf += "<body name=\"b" + std::to_string(i) + "\" pos=\"" + std::to_string(0.1 * i - 7) +
            " 0 0.0199\"><freejoint/><geom type=\"sphere\" size=\"0.02\" mass=\"0.1\"/></body>";
  }
  auto model = compile(mjcf + "</worldbody></mujoco>", {}, "many spheres");
  ASSERT_TRUE(model.ok()) << model.error().message;
  Data data(*model);
  ContactLog log(model->get());
  for (int k = 0; k < 5; ++k) {
    mj_step(model->get(), data.get());
    log.record(model->get(), data.get(), 0.002 * k);
  }
  EXPECT_EQ(log.contacts().size(), static_cast<std::size_t>(Verdict::kMostContacts));
  EXPECT_EQ(log.unlisted(), 12);
}

TEST(Execution, logs_who_touched_the_object_when_and_how_hard) {
  const JudgeRequest request = good_request(Mode::execute);
  const Verdict v = judged(request);
  ASSERT_TRUE(v.success) << v.reason;
  const double arrived = request.dt * static_cast<double>(request.q.rows() - 1), lifted_at = arrived + 0.1 + 0.5;
  const Contact* table = contact(v, "c1", "table");
  if (!table) table = contact(v, "table", "c1");
  ASSERT_NE(table, nullptr);
  EXPECT_LT(table->begin, 0.05);
  EXPECT_GT(table->end, lifted_at) << "it stands until it is lifted";
  EXPECT_LT(table->end, lifted_at + 1.0);
  const double end = v.steps * request.settings.timestep;
  const Contact* thumb = nullptr;
  for (const auto& pair : v.contacts) {
    if (pair.second != "c1" || pair.first.find("thumb") == std::string::npos) continue;
    if (!thumb || pair.end > thumb->end) thumb = &pair;
  }
  ASSERT_NE(thumb, nullptr);
  EXPECT_GT(thumb->begin, 0.5 * arrived);
  EXPECT_GT(thumb->end, end - 0.1) << "it is held to the end";
  // The thumb alone opposes the fingers, and friction of 0.9 carries 0.3 kg: from both sides at least m g / (2 · 0.9).
  EXPECT_GT(thumb->peak_force, 0.3 * 9.81 / 1.8);
  EXPECT_LT(thumb->peak_force, 100);
  EXPECT_EQ(v.unlisted_contacts, 0);
  EXPECT_EQ(v.criteria.size(), judged(good_request(Mode::final_pose)).criteria.size());
}

TEST(Execution, a_fast_wrist_is_where_it_should_be_as_long_as_its_drive_can) {
  // Rigid links under computed torques: what is left is the error of one explicit step. The wrist needs a tenth of its
  // 20 N·m; the derivative gain times its speed, which is no torque of a drive that keeps up, would be 30 N·m.
  const auto& robot = world().robot;
  const int wrist = 5;
  JudgeRequest request = good_request(Mode::execute);
  request.scenario.objects[0].position = {1.0, 0.2, 0.724};  // out of the way
  request.q = robot.home().transpose().replicate(33, 1);
  for (int t = 0; t <= 32; ++t) {
    const double x = t / 32.0;
    request.q(t, wrist) -= 1.0 * x * x * (3 - 2 * x);
  }
  const double dt = 1.0 / 32;  // so that it turns by 1 rad in 1 s, at most by 1.5 rad/s
  auto model = assemble(&robot, request.scenario);
  ASSERT_TRUE(model.ok()) << model.error().message;
  Simulation simulation(robot, request, std::move(model).value(), "c1");
  double error = 0;
  for (int k = 0; k < simulation.steps_in(1.0); ++k) {
    const Reference reference = reference_at(request.q, dt, k * simulation.timestep());
    ASSERT_TRUE(simulation.step(reference, Simulation::Fingers::follow, false));
    error = std::max(error, simulation.tracking_error(reference));
  }
  EXPECT_LT(error, 0.005);
}

TEST(Execution, a_reference_is_at_rest_before_its_beginning_and_after_its_end) {
  Eigen::MatrixXd q(4, 1);
  q << 0, 1, 4, 5;
  for (const double time : {-0.1, 0.4}) {
    const Reference r = reference_at(q, 0.1, time);
    EXPECT_EQ(r.q[0], time < 0 ? 0 : 5);
    EXPECT_EQ(r.velocity[0], 0);
    EXPECT_EQ(r.acceleration[0], 0);
  }
  EXPECT_NE(reference_at(q, 0.1, 0.0).acceleration[0], 0);
}

TEST(Execution, the_judges_own_motions_keep_the_arms_speeds_and_the_line) {
  const auto& robot = world().robot;
  const Eigen::VectorXd q = request_for(world().scenario, *world().good).q.bottomRows(1).transpose();
  const Pose X = robot.pose(robot.forward(q), robot.grasp_frame());
  const Eigen::Vector3d back = -0.15 * X.linear().col(2);
  const Eigen::MatrixXd path = straight_path(robot, q, back, 20);
  for (Eigen::Index k = 0; k <= 20; ++k) {
    const Pose at = robot.pose(robot.forward(path.row(k).transpose()), robot.grasp_frame());
    const Eigen::Vector3d moved = at.translation() - X.translation();
    EXPECT_LT((moved - moved.dot(back.normalized()) * back.normalized()).norm(), 1e-3) << k;
    EXPECT_LT(Eigen::AngleAxisd(X.linear().transpose() * at.linear()).angle(), 0.01) << k;
  }
  // The time of a row: what the fastest joint needs at its limit, of 2 rad/s here.
  const double step = (path.bottomRows(20) - path.topRows(20)).leftCols(robot.arm_joints()).cwiseAbs().maxCoeff();
  EXPECT_NEAR(row_seconds(robot, path, 0.3 * step), 0.5 * step, 1e-12);
  EXPECT_EQ(row_seconds(robot, path, step), step);
  EXPECT_NEAR(row_seconds(robot, path, 0.1 * step), 0.4 * step, 1e-12) << "at most four times as long";
}

TEST(Execution, a_recording_shows_the_lift_and_changes_nothing) {
  const JudgeRequest request = good_request(Mode::execute);
  Recording recording;
  recording.interval = 0.1;
  const Verdict v = judged(request, &recording);
  EXPECT_EQ(testing::bytes(v), testing::bytes(judged(request)));
  const double seconds = v.steps * request.settings.timestep;
  EXPECT_NEAR(static_cast<double>(recording.frames.size()), seconds / 0.1, 2);
  EXPECT_LT((recording.frames.front().q - request.q.row(0).transpose()).cwiseAbs().maxCoeff(), 1e-2);
  const double z0 = recording.frames.front().X_WO[0].translation().z(),
               z = recording.frames.back().X_WO[0].translation().z();
  EXPECT_NEAR(z - z0, 0.1, 0.02);  // lifted by 0.1 m
}

TEST(Execution, a_neighbour_in_the_way_is_knocked_over) {
  JudgeRequest request = good_request(Mode::execute);
  const auto& robot = world().robot;
  const Eigen::Vector3d p = robot.forward(request.q.bottomRows(1).transpose())
                                .X_WB[static_cast<std::size_t>(robot.body("palm"))]
                                .translation();
  scene::Object pole;
  pole.name = "o1";
  pole.radius = 0.015;
  pole.height = 0.25;
  pole.position = {p.x() + 0.02, p.y(), request.scenario.table.top_centre.z() + pole.height / 2};
  request.scenario.objects.push_back(pole);
  const Verdict v = judged(request);
  EXPECT_FALSE(v.success);
  EXPECT_TRUE(v.before.contains({"upright", {"o1"}}));
  EXPECT_FALSE(v.after.contains({"upright", {"o1"}})) << v.reason;
  EXPECT_TRUE(std::any_of(v.contacts.begin(), v.contacts.end(),
                          [](const Contact& pair) { return pair.second == "o1" && from_the_robot(pair); }));
}

TEST(Execution, an_object_swept_off_the_table_stands_on_it_no_more) {
  // In from the side, so that the thumb or the fingers push the object ahead of them, over the edge of a small table.
  JudgeRequest request = good_request(Mode::execute);
  const auto sweep = testing::sideways_sweep(world().robot, request.q.bottomRows(1).transpose());
  ASSERT_TRUE(sweep.has_value());
  testing::set_motion(request, *sweep);
  request.scenario.table.top_centre.head<2>() = request.scenario.objects[0].position.head<2>();
  request.scenario.table.size = {0.12, 0.12};
  const Verdict v = judged(request);
  EXPECT_FALSE(v.success);
  EXPECT_TRUE(v.before.contains({"on", {"c1", "table"}}));
  EXPECT_FALSE(v.after.contains({"on", {"c1", "table"}})) << v.reason;
  EXPECT_FALSE(v.after.contains({"inhand", {"c1"}}));
}

TEST(Survival, the_table_falls_with_the_amplitude_and_leaves_the_verdict_alone) {
  JudgeRequest request = good_request(Mode::final_pose);
  const Verdict plain = judged(request);
  ASSERT_EQ(plain.outcome, Outcome::held);
  EXPECT_TRUE(plain.survivals.empty());
  request.settings.survival_amplitudes = {0.5, 1.0, 3.0};
  request.settings.survival_seeds = 12;
  Verdict v = judged(request);
  ASSERT_EQ(v.survivals.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Survival& row = v.survivals[i];
    EXPECT_EQ(row.amplitude, request.settings.survival_amplitudes[i]);
    EXPECT_EQ(row.seeds, 12);
    EXPECT_GE(row.survival, static_cast<double>(row.held) / row.seeds - 1e-12);
    EXPECT_LE(row.survival, 1 + 1e-12);
    if (i == 0) continue;
    EXPECT_LE(row.held, v.survivals[i - 1].held);
    EXPECT_GT(row.displacement, v.survivals[i - 1].displacement);
  }
  EXPECT_EQ(v.survivals[0].held, 12);
  EXPECT_LE(v.survivals[2].held, 2);
  v.survivals.clear();
  EXPECT_EQ(testing::bytes(v), testing::bytes(plain));
}

/// The robot with some of its file's text exchanged.
Result<robot::Robot> robot_with(const std::string& from, const std::string& to) {
  const std::filesystem::path folder = std::filesystem::path(PRIMO_SOURCE_DIR) / "configs/robots";
  PRIMO_ASSIGN(std::string text, read_file(folder / "schunk_lwa3_sdh2.yaml"));
  const auto exchange = [&](const std::string& a, const std::string& b) {
    for (auto at = text.find(a); at != std::string::npos; at = text.find(a, at + b.size()))
      text.replace(at, a.size(), b);
  };
  exchange("mjcf: ", "mjcf: " + folder.string() + "/");
  exchange(from, to);
  const auto file = std::filesystem::path(::testing::TempDir()) / "primo_wild_robot.yaml";
  PRIMO_TRY(write_file(file, text));
  return robot::Robot::load(file);
}

TEST(Unstable, a_hand_that_makes_the_simulation_diverge_is_no_success_and_its_step_is_named) {
  // Servos so stiff that no time step holds them.
  const auto wild = robot_with("kp: 30, kd: 0.5, max_torque: 1.4", "kp: 1.0e+12, kd: 0.5, max_torque: 1.0e+15");
  ASSERT_TRUE(wild.ok()) << wild.error().message;
  const Judge judge(*wild);
  for (const Mode mode : {Mode::final_pose, Mode::execute}) {
    const auto v = judge.evaluate(good_request(mode));
    ASSERT_TRUE(v.ok()) << v.error().message;
    EXPECT_EQ(v->outcome, Outcome::unstable) << v->reason;
    EXPECT_FALSE(v->success);
    EXPECT_FALSE(v->final_pose_success);
    EXPECT_GT(v->steps, 0);
    EXPECT_NE(v->reason.find("step " + std::to_string(v->steps)), std::string::npos) << v->reason;
    EXPECT_EQ(v->after, v->before);
    EXPECT_EQ(v->score, 0);
    EXPECT_TRUE(std::isfinite(v->displacement));
  }
}

TEST(Unstable, an_arm_that_makes_the_simulation_diverge_is_no_success) {
  const auto wild = robot_with("kp: 4000, kd: 200, max_torque: 370", "kp: 1.0e+13, kd: 200, max_torque: 1.0e+16");
  ASSERT_TRUE(wild.ok()) << wild.error().message;
  const auto v = Judge(*wild).evaluate(good_request(Mode::execute));
  ASSERT_TRUE(v.ok()) << v.error().message;
  EXPECT_EQ(v->outcome, Outcome::unstable) << v->reason;
  EXPECT_FALSE(v->success);
  EXPECT_NE(v->reason.find("step " + std::to_string(v->steps)), std::string::npos) << v->reason;
}

}  // namespace
}  // namespace primo::physics

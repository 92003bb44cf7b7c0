#include "physics/movie.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/files.h"
#include "grasp_fixture.h"
#include "place_fixture.h"

namespace primo::physics {
namespace {

namespace fs = std::filesystem;

fs::path scratch(const std::string& name) { return fs::path(::testing::TempDir()) / ("primo_movie_" + name); }

struct Film {
  robot::Robot robot = testing::load_robot();
  scene::Scenario scenario = testing::one_cylinder();
  Eigen::MatrixXd q = Eigen::MatrixXd(3, robot.joints());
  MovieOptions options;
  Film() {
    for (int t = 0; t < 3; ++t) q.row(t) = robot.home().transpose();
    q(1, 1) += 0.2;
    q(2, 1) += 0.4;
    options.picture.width = 96;
    options.picture.height = 64;
    options.still_seconds = 0.08;
  }
};

TEST(Replay, goes_through_the_plans_rows_at_their_times) {
  Film film;
  const auto recording = replay(film.robot, film.q, 0.1, film.scenario, 0.05);
  ASSERT_EQ(recording.frames.size(), 5U);
  EXPECT_TRUE(recording.frames[0].q.isApprox(film.q.row(0).transpose()));
  EXPECT_TRUE(recording.frames[1].q.isApprox(0.5 * (film.q.row(0) + film.q.row(1)).transpose()));
  EXPECT_TRUE(recording.frames[4].q.isApprox(film.q.row(2).transpose()));
  EXPECT_TRUE(recording.frames[4].X_WO[0].isApprox(film.scenario.objects[0].X_WO()));
}

TEST(Replay, carries_what_the_hand_holds) {
  const auto robot = testing::load_robot();
  auto request = testing::place_at(robot, {0, 0, 0});
  ASSERT_TRUE(request.has_value());
  const auto recording = replay(robot, request->q, request->dt, request->scenario, request->dt);
  const Pose X_GO = request->scenario.held->X_GO();
  for (const auto& frame : recording.frames) {
    const Pose X_WG = robot.pose(robot.forward(frame.q), robot.grasp_frame());
    EXPECT_TRUE(frame.X_WO[0].isApprox(X_WG * X_GO, 1e-9)) << frame.time;
    EXPECT_TRUE(frame.X_WO[1].isApprox(request->scenario.objects[1].X_WO()));
  }
  // The fixture ends 5 mm above the place on c2.
  const Eigen::Vector3d end = testing::top_of_support(request->scenario) + Eigen::Vector3d(0, 0, 0.005);
  EXPECT_LT((recording.frames.back().X_WO[0].translation() - end).norm(), 1e-3);
}

TEST(Movie, is_an_mp4_file_and_the_same_every_time) {
  Film film;
  const auto recording = replay(film.robot, film.q, 0.1, film.scenario, 0.04);
  const auto a = scratch("a.mp4"), b = scratch("b.mp4"), c = scratch("c.mp4");
  for (const auto& path : {a, b}) {
    const auto status = render_movie(path, film.robot, film.scenario, film.q, recording, film.options);
    ASSERT_TRUE(status.ok()) << status.error().message;
  }
  const std::string bytes = *read_file(a);
  EXPECT_EQ(bytes.substr(4, 4), "ftyp");
  EXPECT_NE(bytes.find("moov"), std::string::npos);
  EXPECT_EQ(bytes, *read_file(b));
  // Another motion is another film.
  film.q(2, 1) -= 0.7;
  ASSERT_TRUE(render_movie(c, film.robot, film.scenario, film.q, replay(film.robot, film.q, 0.1, film.scenario, 0.04),
                           film.options)
                  .ok());
  EXPECT_NE(bytes, *read_file(c));
  for (const auto& path : {a, b, c}) {
    fs::path unfinished = path;
    EXPECT_FALSE(fs::exists(unfinished += ".part"));
    fs::remove(path);
  }
}

TEST(Movie, says_what_is_missing_or_wrong_and_leaves_nothing_behind) {
  Film film;
  const auto recording = replay(film.robot, film.q, 0.1, film.scenario, 0.04);
  const auto path = scratch("x.mp4");
  const auto refusal = [&](const Recording& shown, const MovieOptions& options) {
    const auto status = render_movie(path, film.robot, film.scenario, film.q, shown, options);
    EXPECT_FALSE(fs::exists(path));
    EXPECT_FALSE(fs::exists(fs::path(path.string() + ".part")));
    return status.ok() ? std::string("made") : status.error().message;
  };
  MovieOptions odd = film.options;
  odd.picture.width = 95;
  EXPECT_NE(refusal(recording, odd).find("even"), std::string::npos);
  EXPECT_NE(refusal({}, film.options).find("not 0"), std::string::npos);
  Recording endless = recording;
  endless.frames.resize(6000, recording.frames[0]);
  EXPECT_NE(refusal(endless, film.options).find("6000"), std::string::npos);
  Recording other = recording;
  other.frames[1].q.conservativeResize(3);
  EXPECT_NE(refusal(other, film.options).find("frame"), std::string::npos);
  const std::string search = std::getenv("PATH");
  ASSERT_EQ(setenv("PATH", "/nonexistent", 1), 0);
  EXPECT_NE(refusal(recording, film.options).find("Debian's package ffmpeg"), std::string::npos);
  ASSERT_EQ(setenv("PATH", search.c_str(), 1), 0);
  const auto status =
      render_movie("/nonexistent/folder/x.mp4", film.robot, film.scenario, film.q, recording, film.options);
  EXPECT_FALSE(status.ok());
}

}  // namespace
}  // namespace primo::physics

#include "motion/primitive.h"

#include <cmath>

#include "fixture.h"

namespace primo::motion {
namespace {

TEST(Primitive, BaselineHasThePublishedPrecisions) {
  const std::vector<std::string> names = {"position",   "alignment", "fingers.early", "fingers.late",
                                          "opposition", "collision", "limits",        "homing"};
  EXPECT_EQ(hand_tuned().rho_names(), names);
  const std::vector<double> log_rho = {1, 1, 0, 0, -1, -1, 1, -5};
  ASSERT_EQ(hand_tuned().log_rho().size(), log_rho.size());
  for (std::size_t i = 0; i < log_rho.size(); ++i)
    EXPECT_NEAR(hand_tuned().log_rho()[i], log_rho[i], 1e-12) << names[i];
  EXPECT_EQ(hand_tuned().steps, 64);
  EXPECT_EQ(hand_tuned().duration, 4.0);
}

TEST(Primitive, LogPrecisionsGoInAndOutUnchanged) {
  const std::vector<double> values = {3.5, -2, 0.25, 1, 9, -3, 0, 2};
  const Primitive changed = hand_tuned().with_log_rho(values);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(changed.log_rho()[i], values[i], 1e-12);
  EXPECT_EQ(changed.tasks[2].rho, std::pow(10.0, 0.25));
  EXPECT_EQ(changed.tasks[2].rho_late, 10);
}

TEST(Primitive, ClosedPrecisionsAreNotInTheVector) {
  Primitive primitive = hand_tuned();
  primitive.tasks[2].optimize = false;
  EXPECT_EQ(primitive.log_rho().size(), 6u);
  EXPECT_EQ(primitive.rho_names()[2], "opposition");
}

TEST(Primitive, SurvivesItsDump) {
  const std::string text = config::dump(hand_tuned());
  const auto again = config::read_text<Primitive>(text, "dump");
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(config::dump(*again), text);
}

TEST(Primitive, ErrorsSayWhereAndWhatWouldBeRight) {
  const auto error = [](auto&& change) {
    Primitive primitive = hand_tuned();
    change(primitive);
    const auto status = primitive.validate();
    return status.ok() ? std::string("no error") : status.error().message;
  };
  EXPECT_NE(error([](Primitive& p) { p.tasks[0].variable = "pos"; }).find("position, alignment"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.tasks[1].name = "position"; }).find("twice"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.tasks[0].rho = 0; }).find("optimize: false"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.tasks[0].rho = NAN; }).find("0 … 1e12"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.tasks[0].rho_late = 1; }).find("rho_late"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.solver = "aico?"; }).find("gauss_newton"), std::string::npos);
  EXPECT_NE(error([](Primitive& p) { p.tasks.clear(); }).find("at least one"), std::string::npos);
}

TEST(Primitive, MissingFileIsAnErrorWithItsPath) {
  const auto missing = read_primitive("nowhere/p.yaml");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("nowhere/p.yaml"), std::string::npos);
}

}  // namespace
}  // namespace primo::motion

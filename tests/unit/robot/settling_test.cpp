#include "robot/settling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace primo::robot {
namespace {

/// Two sprung hinges, b = 0.1 + 0.5 a + 0.3 a².
ModelPointer sprung_pair(const std::string& range, double soft = 2, double stiff = 5) {
  const auto hinge = [](const std::string& name, double stiffness, const std::string& more) {
    return "<joint name=\"" + name + "\" axis=\"0 1 0\" stiffness=\"" + std::to_string(stiffness) + "\" springref=\"" +
           more + "/><geom size=\"0.1\"/>";
  };
  return compile_mjcf("<mujoco><compiler angle=\"radian\" autolimits=\"true\"/><worldbody><body>" +
                          hinge("a", soft, "1.2\" " + range) + "<body pos=\"0 0 1\">" + hinge("b", stiff, "-0.4\"") +
                          "</body></body></worldbody><equality><joint joint1=\"b\" joint2=\"a\" polycoef=\"0.1 0.5 "
                          "0.3 0 0\"/></equality></mujoco>",
                      {}, "test")
      .value();
}

/// Where ½ k₁ (a − 1.2)² + ½ k₂ (b(a) + 0.4)² is least: its derivative's root by bisection.
double least_energy(double soft, double stiff) {
  const auto slope = [&](double a) {
    return soft * (a - 1.2) + stiff * (0.1 + 0.5 * a + 0.3 * a * a + 0.4) * (0.5 + 0.6 * a);
  };
  double low = -0.8, high = 1.2;
  for (int k = 0; k < 60; ++k) (slope((low + high) / 2) < 0 ? low : high) = (low + high) / 2;
  return low;
}

TEST(Settling, FindsTheLeastEnergyThatItsEqualitiesAllow) {
  for (const auto& [soft, stiff] : {std::pair(2.0, 5.0), std::pair(0.5, 20.0), std::pair(0.05, 0.01)}) {
    const auto model = sprung_pair("", soft, stiff);
    Settling settling(*model, {1, 1});
    const auto rest = settling.settle(true);
    const double a = settling.at(0), b = settling.at(1);
    EXPECT_TRUE(rest.found);
    EXPECT_TRUE(rest.closed());
    EXPECT_EQ(rest.unheld, -1);
    EXPECT_NEAR(b, 0.1 + 0.5 * a + 0.3 * a * a, 1e-9);
    // The solver lets a loaded constraint yield by 1e-4 of the springs' way, which matters more where the energy is
    // flat.
    EXPECT_NEAR(a, least_energy(soft, stiff), 2e-3) << soft << " " << stiff;
  }
}

TEST(Settling, RestsOnALimitThatIsInTheWay) {
  const double free = least_energy(2, 5);
  const auto model = sprung_pair("range=\"-2 " + std::to_string(free - 0.2) + "\"");
  Settling settling(*model, {1, 1});
  EXPECT_TRUE(settling.settle().closed());
  EXPECT_NEAR(settling.at(0), free - 0.2, 1e-4);
}

TEST(Settling, LeavesHeldJointsWhereTheyAreSet) {
  const auto model = sprung_pair("");
  Settling settling(*model, {0, 1});
  settling.set(0, 0.6);
  EXPECT_TRUE(settling.settle().closed());
  EXPECT_EQ(settling.at(0), 0.6);
  EXPECT_NEAR(settling.at(1), 0.1 + 0.3 + 0.3 * 0.36, 1e-7);
}

TEST(Settling, SaysHowFarAConstraintIsFromBeingMetAndWhich) {
  const auto model = sprung_pair("range=\"-2 0.5\"");
  Settling settling(*model, {1, 1});
  settling.set(0, 0.0);
  settling.set(1, 0.35);
  auto rest = settling.measure();
  EXPECT_NEAR(rest.open, 0.25, 1e-12);
  EXPECT_EQ(rest.equality, 0);
  settling.set(0, 0.9);
  settling.set(1, 0.1 + 0.45 + 0.3 * 0.81);
  rest = settling.measure();
  EXPECT_NEAR(rest.open, 0.4, 1e-12);
  EXPECT_EQ(rest.equality, -1);
  EXPECT_EQ(rest.joint, 0);
  EXPECT_FALSE(rest.closed());
}

TEST(Settling, NamesAJointThatNothingHolds) {
  const auto model = sprung_pair("", 0, 0);
  Settling settling(*model, {1, 1});
  EXPECT_GE(settling.settle(true).unheld, 0);
  EXPECT_EQ(Settling(*sprung_pair("", 1, 0), {1, 1}).settle(true).unheld, -1);
}

}  // namespace
}  // namespace primo::robot

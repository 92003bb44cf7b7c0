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

Primitive searched() {
  Primitive primitive = hand_tuned();
  auto &position = primitive.tasks[0], &fingers = primitive.tasks[2], &homing = primitive.tasks[6];
  position.search["at"] = {.min = 0.6, .max = 0.95};
  position.search["rho"] = {.min = 0.1, .max = 1e6};
  fingers.search["target.0"] = {.min = 0.5, .max = 1.5};
  fingers.search["rho"] = {.fixed = true};
  fingers.search["rho_late"] = {.scale = Scale::linear, .min = 0, .max = 50};
  homing.optimize = false;
  return primitive;
}

TEST(Primitive, DeclaresWhatIsSearchedOnWhichScaleAndWithinWhichBounds) {
  ASSERT_TRUE(searched().validate().ok()) << searched().validate().error().message;
  struct Expected {
    std::string name;
    bool log;
    double value, lower, upper;
  };
  // By hand from the baseline's file: ρ 10, 10, 1 | 1, 0.1, 0.1, 10; limits of the study −3 and 9.
  const std::vector<Expected> expected = {{"position", true, 1, -1, 6},
                                          {"position.at", false, 0.8, 0.6, 0.95},
                                          {"alignment", true, 1, -3, 9},
                                          {"fingers.late", false, 1, 0, 50},
                                          {"fingers.target.0", false, 1, 0.5, 1.5},
                                          {"opposition", true, -1, -3, 9},
                                          {"collision", true, -1, -3, 9},
                                          {"limits", true, 1, -3, 9}};
  const auto entries = searched().open_entries(-3, 9);
  ASSERT_EQ(entries.size(), expected.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ(entries[i].name, expected[i].name);
    EXPECT_EQ(entries[i].log, expected[i].log) << entries[i].name;
    EXPECT_NEAR(entries[i].value, expected[i].value, 1e-12) << entries[i].name;
    EXPECT_NEAR(entries[i].lower, expected[i].lower, 1e-12) << entries[i].name;
    EXPECT_NEAR(entries[i].upper, expected[i].upper, 1e-12) << entries[i].name;
  }
}

TEST(Primitive, TakesCoordinatesIntoItsOpenEntriesAndNothingElse) {
  const Primitive changed = searched().with_entries({5, 0.7, -2, 20, 1.25, 0, 0, 0});
  EXPECT_EQ(changed.tasks[0].rho, 1e5);
  EXPECT_EQ(changed.tasks[0].at, 0.7);
  EXPECT_EQ(changed.tasks[1].rho, 0.01);
  EXPECT_EQ(changed.tasks[2].rho_late, 20);
  EXPECT_EQ(changed.tasks[2].target[0], 1.25);
  EXPECT_EQ(changed.tasks[2].rho, hand_tuned().tasks[2].rho) << "fixed";
  EXPECT_EQ(changed.tasks[6].rho, hand_tuned().tasks[6].rho) << "closed";
  EXPECT_TRUE(changed.validate().ok());
  const auto entries = changed.open_entries(-3, 9);
  EXPECT_NEAR(entries[0].value, 5, 1e-12);
  EXPECT_EQ(entries[1].value, 0.7);
}

TEST(Primitive, ReadsItsSearchFromYaml) {
  std::string text = config::dump(hand_tuned());
  const auto at = text.find("    search:\n      {}");
  ASSERT_NE(at, std::string::npos) << text;
  text.replace(at, std::string("    search:\n      {}").size(),
               "    search: {at: {min: 0.5, max: 0.9}, rho: {scale: log, min: 1, max: 100}}");
  const auto read = config::read_text<Primitive>(text, "p.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->tasks[0].search.at("at").max, 0.9);
  EXPECT_EQ(read->open_entries(-3, 9)[0].upper, 2);
  const std::string again = config::dump(*read);
  EXPECT_EQ(config::dump(*config::read_text<Primitive>(again, "again")), again);
}

TEST(Primitive, SearchErrorsSayWhatWouldBeRight) {
  const auto error = [](std::size_t task, const std::string& entry, Search search) {
    Primitive primitive = hand_tuned();
    primitive.tasks[task].search[entry] = search;
    const auto status = primitive.validate();
    return status.ok() ? std::string("no error") : status.error().message;
  };
  EXPECT_NE(error(0, "rhoo", {}).find("it has rho, at"), std::string::npos) << error(0, "rhoo", {});
  EXPECT_NE(error(0, "rho_late", {}).find("no entry of this task"), std::string::npos);
  EXPECT_NE(error(4, "at", {.min = 0.1, .max = 0.5}).find("no entry"), std::string::npos) << "constant has no phases";
  EXPECT_NE(error(2, "target.1", {.min = 0, .max = 1}).find("target.0"), std::string::npos);
  EXPECT_NE(error(0, "at", {}).find("min and max are needed"), std::string::npos);
  EXPECT_NE(error(0, "at", {.min = 0.9, .max = 0.6}).find("min is 0.9, must be below max, 0.6"), std::string::npos);
  EXPECT_NE(error(0, "at", {.min = 0.5, .max = 1.5}).find("0 … 1"), std::string::npos);
  EXPECT_NE(error(0, "rho", {.min = 0, .max = 5}).find("positive on a log scale"), std::string::npos);
  EXPECT_NE(error(0, "rho", {.scale = Scale::linear}).find("min and max are needed"), std::string::npos);
  EXPECT_NE(error(3, "target.0", {.scale = Scale::log, .min = 1, .max = 2}).find("only a positive entry"),
            std::string::npos);
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

// MJCF as Menagerie-style models write it: what is read from it, what of it is refused and in which words.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "core/files.h"
#include "core/random.h"
#include "robot/files_digest.h"
#include "robot/mjcf.h"
#include "robot/mjcf_features.h"
#include "robot_text.h"
#include "style_text.h"

namespace primo::robot {
namespace {

TEST(MjcfStyle, PosesAgreeWithMuJoCosReadingOfTheSameFiles) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  auto loaded = folder.load();
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  const Robot& robot = *loaded;
  ASSERT_EQ(robot.joints(), 4);
  EXPECT_NEAR(robot.lower()[0], -170 * M_PI / 180, 1e-12);
  EXPECT_NEAR(robot.upper()[1], 120 * M_PI / 180, 1e-12);
  EXPECT_EQ(robot.upper()[3], 0.04);
  EXPECT_FALSE(robot.slides(2));
  EXPECT_TRUE(robot.slides(3));
  EXPECT_NEAR(robot.radian(3), 0.04 / M_PI, 1e-15);
  EXPECT_EQ(robot.link_shapes().size(), 7U) << "meshes to be seen are no shapes";
  const ModelPointer model(mj_loadXML(folder.path("robot.xml").c_str(), nullptr, nullptr, 0));
  ASSERT_TRUE(model);
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model.get()), &mj_deleteData);
  for (std::uint64_t i = 0; i < 50; ++i) {
    Random random(1, "style", {i});
    Eigen::VectorXd q(4);
    for (int j = 0; j < 4; ++j) q[j] = random.uniform(robot.lower()[j], robot.upper()[j]);
    std::copy_n(q.data(), 4, data->qpos);
    data->qpos[4] = q[3];
    mj_kinematics(model.get(), data.get());
    const Kinematics at = robot.forward(q);
    for (const auto& body : robot.bodies()) {
      const int id = mj_name2id(model.get(), mjOBJ_BODY, body.name.c_str()), own = robot.body(body.name);
      ASSERT_GE(id, 0) << body.name;
      EXPECT_LT((at.X_WB[own].translation() - Eigen::Map<Eigen::Vector3d>(data->xpos + 3 * id)).norm(), 1e-12);
    }
    const int site = mj_name2id(model.get(), mjOBJ_SITE, "centre");
    const Pose X_WG = robot.pose(at, robot.grasp_frame());
    EXPECT_LT((X_WG.translation() - Eigen::Map<Eigen::Vector3d>(data->site_xpos + 3 * site)).norm(), 1e-12);
    const Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->site_xmat + 9 * site);
    EXPECT_LT((X_WG.linear() - R).norm(), 1e-12);
  }
}

TEST(MjcfStyle, TheRobotFileSaysWhereTheModelStands) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  // Two world sections, and something of the world's own.
  std::string text = *read_file(folder.path("robot.xml"));
  text.replace(text.find("<contact>"), 0,
               "<worldbody><geom name=\"stand\" type=\"box\" size=\"0.1 0.1 0.2\"/></worldbody>");
  folder.put("robot.xml", text);
  const auto here = folder.load();
  ASSERT_TRUE(here.ok()) << here.error().message;
  folder.put("robot.yaml",
             *read_file(folder.path("robot.yaml")) + "base: {position: [0.25, -0.1, 0.67], rpy: [0.1, 0.2, 0.5]}\n");
  const auto there = folder.load();
  ASSERT_TRUE(there.ok()) << there.error().message;
  const Pose X_WM = primo::pose(Eigen::Vector3d(0.25, -0.1, 0.67), Eigen::Vector3d(0.1, 0.2, 0.5));
  Eigen::VectorXd q(4);
  q << 0.3, -0.4, 0.5, 0.02;
  const Kinematics before = here->forward(q), after = there->forward(q);
  const auto same = [&](const Pose& X_before, const Pose& X_after) {
    return (X_after.matrix() - (X_WM * X_before).matrix()).norm() < 1e-12;
  };
  EXPECT_TRUE(same(here->pose(before, here->grasp_frame()), there->pose(after, there->grasp_frame())));
  ASSERT_EQ(here->link_shapes().size(), there->link_shapes().size());
  for (std::size_t i = 0; i < here->link_shapes().size(); ++i) {
    const LinkShape &a = here->link_shapes()[i], &b = there->link_shapes()[i];
    EXPECT_TRUE(same(here->pose(before, a), there->pose(after, b))) << a.name << ", " << b.name;
  }
  // And so for MuJoCo, which the physics gets the same text from.
  const auto model = compile_robot(there->mjcf(), there->mjcf_path());
  ASSERT_TRUE(model.ok()) << model.error().message;
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model->get()), &mj_deleteData);
  std::copy_n(q.data(), 4, data->qpos);
  data->qpos[4] = q[3];
  mj_kinematics(model->get(), data.get());
  const int palm = mj_name2id(model->get(), mjOBJ_BODY, "hand");
  ASSERT_GE(palm, 0);
  EXPECT_LT((before.X_WB[static_cast<std::size_t>(here->body("hand"))].translation() -
             X_WM.inverse() * Eigen::Map<Eigen::Vector3d>(data->xpos + 3 * palm))
                .norm(),
            1e-12);
}

TEST(FilesDigest, ChangesWithEveryFileOfTheModelAndWithNothingElse) {
  const RobotFolder folder, copy;
  write_model(folder, kJaws);
  write_model(copy, kJaws);
  const auto digest = [](const RobotFolder& of) {
    auto found = files_digest(of.path("robot.yaml"), of.path("robot.xml"));
    EXPECT_TRUE(found.ok()) << (found.ok() ? "" : found.error().message);
    return found.ok() ? *found : std::string();
  };
  const std::string before = digest(folder);
  EXPECT_FALSE(before.empty());
  EXPECT_EQ(digest(copy), before) << "where the files lie does not matter";
  std::set<std::string> seen = {before};
  const std::map<std::string, std::pair<std::string, std::string>> changes = {
      {"robot.yaml", {"max_torque: 40", "max_torque: 41"}},
      {"robot.xml", {"pos=\"0 0 0.25\"", "pos=\"0 0 0.26\""}},
      {"defaults.xml", {"armature=\"0.1\" damping", "armature=\"0.2\" damping"}},
      {"hand.xml", {"size=\"0.03 0.1 0.03\"", "size=\"0.03 0.1 0.04\""}},
      {"meshes/wedge.obj", {"v 0 0 .2", "v 0 0 .3"}}};
  for (const auto& [file, change] : changes) {
    std::string text = *read_file(folder.path(file));
    const auto at = text.find(change.first);
    ASSERT_NE(at, std::string::npos) << file;
    folder.put(file, text.replace(at, change.first.size(), change.second));
    EXPECT_TRUE(seen.insert(digest(folder)).second) << file;
    write_model(folder, kJaws);
    EXPECT_EQ(digest(folder), before) << file;
  }
  std::filesystem::remove(folder.path("meshes/wedge.obj"));
  const auto missing = files_digest(folder.path("robot.yaml"), folder.path("robot.xml"));
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("wedge.obj"), std::string::npos) << missing.error().message;
}

TEST(MjcfStyle, CouplingsByJointsAndByTendonsAreSolvedForTheUnlistedJoint) {
  struct Case {
    std::string text;
    double offset, ratio;  // of joint two, from joint one
  };
  for (const auto& [text, offset, ratio] : {
           Case{kJaws, 0, 1},
           Case{R"(<joint joint1="one" joint2="two"/>)", 0, 1},
           Case{R"(<joint joint1="one" joint2="two" polycoef="0.01 2 0 0 0"/>)", -0.005, 0.5},
           // 2 two = 0.01 + 0.5 one
           Case{R"(<tendon tendon1="jaw_two" tendon2="jaw_one" polycoef="0.01 0.5 0 0 0"/>)", 0.005, 0.25},
           // one − two = 0
           Case{R"(<tendon tendon1="difference" polycoef="0 1 0 0 0"/>)", 0, 1},
           // The same said twice.
           Case{std::string(kJaws) + R"(<tendon tendon1="difference"/>)", 0, 1},
       }) {
    const RobotFolder folder;
    write_model(folder, text);
    auto robot = folder.load();
    ASSERT_TRUE(robot.ok()) << text << ": " << robot.error().message;
    const auto& two = robot->chain().back();
    ASSERT_EQ(two.name, "two");
    EXPECT_EQ(two.index, 3);
    EXPECT_NEAR(two.offset, offset, 1e-15) << text;
    EXPECT_NEAR(two.ratio, ratio, 1e-15) << text;
  }
}

TEST(MjcfStyle, CouplingsThatCannotBePlannedWithAreRefusedInWords) {
  const std::map<std::string, std::string> cases = {
      {R"(<connect body1="one" body2="two" anchor="0 0 0"/>)", "beyond its range"},
      {R"(<connect body1="l3" body2="foot" anchor="0 0 0"/>)" + std::string(kJaws), "of the arm"},
      {R"(<joint joint1="two" joint2="one" polycoef="0 1 1 0 0"/>)", "polynomial"},
      {R"(<joint joint1="q2" joint2="q1"/>)", "couples joint 'q2' to 'q1', 'q2'"},
      {"", "joint 'two' of"},
      {std::string(kJaws) + R"(<tendon tendon1="split"/>)", "couples joint"},
  };
  for (const auto& [text, words] : cases) {
    const RobotFolder folder;
    write_model(folder, text);
    EXPECT_NE(folder.error().find(words), std::string::npos) << text << ": " << folder.error();
    EXPECT_NE(folder.error().find("robot.xml"), std::string::npos) << folder.error();
  }
}

/// A document that has the feature, or the same without it.
std::string document(const MjcfFeature& feature, bool with) {
  const std::string name = feature.element;
  std::string attribute =
      *feature.attribute ? std::string(" ") + feature.attribute + "=\"" + (*feature.value ? feature.value : "1") + "\""
                         : "";
  const std::string element = with ? "<" + name + attribute + "/>" : "";
  if (!with) attribute.clear();
  std::string option, size, compiler = "<compiler/>", asset, body, joint, geom = "<geom size=\"1\"/>", actuator,
                            equality, world, top;
  if (name == "option") option = "<option" + attribute + "/>";
  if (name == "size") size = "<size" + attribute + "/>";
  if (name == "compiler") compiler = "<compiler" + attribute + "/>";
  if (name == "body") body = attribute;
  if (name == "joint") joint = attribute;
  if (name == "geom") geom = "<geom size=\"1\"" + attribute + "/>";
  if (name == "position" || name == "intvelocity")
    actuator = "<" + name + (name == "position" ? " joint=\"j\"" : " joint=\"j\" actrange=\"-1 1\"") + attribute + "/>";
  if (name.empty()) actuator = "<general joint=\"j\"" + attribute + "/>";
  if (name == "connect" || name == "weld")
    equality = "<" + name + " body1=\"b\" " + (name == "connect" ? "anchor=\"0 0 0\"" : "") + attribute + "/>";
  if (name == "mesh") asset = "<mesh name=\"m\" vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\"" + attribute + "/>";
  if (name == "texture")
    asset = "<texture builtin=\"flat\" type=\"2d\" name=\"t\" width=\"8\" height=\"8\"" + attribute + "/>";
  if (name == "layer") asset = "<material name=\"m\">" + element + "</material>";
  if (name == "model") asset = element;
  if (name == "frame" || name == "replicate" || name == "attach" || name == "flexcomp") world = element;
  if (name == "plugin" || name == "extension" || name == "flex") top = element;
  return "<mujoco>\n" + compiler + option + size + "<asset>" + asset + "</asset><worldbody>" + world +
         "<body name=\"b\"" + body + "><joint name=\"j\"" + joint + "/>" + geom + "</body></worldbody>\n<actuator>" +
         actuator + "</actuator><equality>" + equality + "</equality>" + top + "</mujoco>";
}

TEST(MjcfFeatures, EveryOneIsRefusedByMuJoCoAndNamedWithElementFileAndLine) {
  ASSERT_GT(unread_features().size(), 20U);
  for (const auto& feature : unread_features()) {
    const std::string label = std::string(feature.element) + " " + feature.attribute + " " + feature.value;
    const RobotFolder folder;
    folder.put("robot.xml", document(feature, false));
    ASSERT_TRUE(compile_mjcf(document(feature, false), {}, "plain").ok())
        << label << ": " << compile_mjcf(document(feature, false), {}, "plain").error().message;
    EXPECT_TRUE(read_mjcf(folder.path("robot.xml")).ok()) << label;
    EXPECT_FALSE(compile_mjcf(document(feature, true), {}, "with").ok()) << label << " can be read after all";
    folder.put("robot.xml", document(feature, true));
    const auto refused = read_mjcf(folder.path("robot.xml"));
    ASSERT_FALSE(refused.ok()) << label;
    const std::string& message = refused.error().message;
    EXPECT_TRUE(message.find("robot.xml:2: ") != std::string::npos ||
                message.find("robot.xml:3: ") != std::string::npos)
        << message;
    for (const char* word : {feature.element, feature.attribute, feature.value, feature.instead})
      EXPECT_NE(message.find(word), std::string::npos) << message;
  }
}

TEST(MjcfFeatures, OthersThatMuJoCoDoesNotKnowAreRefusedWithTheFilesLine) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  folder.put(
      "robot.xml",
      "<mujoco>\n<worldbody>\n<body name=\"b\">\n<geom size=\"1\" glitter=\"7\"/>\n</body>\n</worldbody>\n</mujoco>");
  const std::string error = folder.error();
  EXPECT_NE(error.find("robot.xml:4: MuJoCo 2.2.2 does not know attribute glitter of element <geom>"),
            std::string::npos)
      << error;
}

TEST(MjcfFeatures, OthersInAnIncludedFileAreRefusedWithThatFileAndLine) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  // Puts `more` behind `after`, and expects the error to have that file, that line and the words.
  const auto expect = [&](const std::string& file, const std::string& after, const std::string& more,
                          const std::string& words) {
    write_model(folder, kJaws);
    std::string text = *read_file(folder.path(file));
    const auto at = text.find(after);
    ASSERT_NE(at, std::string::npos) << after;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    folder.put(file, text.insert(at + after.size(), more));
    const std::string error = folder.error(),
                      expected = file + ":" + std::to_string(line) + ": MuJoCo 2.2.2 does not know " + words;
    EXPECT_NE(error.find(expected), std::string::npos) << error << "\nexpected: " << expected;
  };
  // Geoms without the attribute come before it, in this file and in the main one.
  expect("hand.xml", "<geom class=\"felt\" type=\"box\" size=\"0.01 0.01 0.025\"", " sheen=\"1\"",
         "attribute sheen of element <geom>");
  expect("defaults.xml", "<default class=\"jaw\">", "<sheen/>", "element <sheen>");
}

TEST(MjcfStyle, LightsAndCamerasOfTheRobotDoNotReachTheScene) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  std::string text = *read_file(folder.path("robot.xml"));
  text.replace(text.find("<worldbody>"), 11, R"(<worldbody><light name="top" pos="0 0 2" mode="trackcom"/>)");
  text.replace(text.find("<body name=\"l2\""), 0, R"(<camera name="wrist"/><light pos="0 0 1"/>)");
  folder.put("robot.xml", text);
  const auto robot = folder.load();
  ASSERT_TRUE(robot.ok()) << robot.error().message;
  const auto model = compile_robot(robot->mjcf(), robot->mjcf_path());
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ((*model)->nlight, 0);
  EXPECT_EQ((*model)->ncam, 0);
  EXPECT_EQ((*model)->nbody, 8) << "the world, four of the arm, the hand and its two fingers";
}

TEST(MjcfFeatures, WhatWouldReachBeyondTheRobotIsRefused) {
  const RobotFolder folder;
  folder.put("robot.xml", "<mujoco>\n<compiler settotalmass=\"3\"/></mujoco>");
  EXPECT_NE(read_mjcf(folder.path("robot.xml")).error().message.find("robot.xml:2: settotalmass"), std::string::npos);
  folder.put("robot.xml", "<mujoco>\n<compiler coordinate=\"global\"/></mujoco>");
  EXPECT_NE(read_mjcf(folder.path("robot.xml")).error().message.find("coordinate"), std::string::npos);
}

TEST(MjcfFeatures, AFeatureInAnIncludedFileIsNamedWithThatFile) {
  const RobotFolder folder;
  write_model(folder, kJaws);
  folder.put("hand.xml", "<mujocoinclude>\n\n<body name=\"hand\" gravcomp=\"1\"/></mujocoinclude>");
  const std::string error = folder.error();
  EXPECT_NE(error.find("hand.xml:3: attribute gravcomp=\"1\" of element <body>"), std::string::npos) << error;
}

TEST(MjcfIncludes, MissingRepeatedAndCircularOnesAreErrors) {
  const RobotFolder folder;
  const auto error = [&](const std::string& text) {
    folder.put("robot.xml", text);
    const auto read = read_mjcf(folder.path("robot.xml"));
    return read.ok() ? "no error" : read.error().message;
  };
  folder.put("part.xml", "<mujocoinclude><default/></mujocoinclude>");
  folder.put("loop.xml", "<mujocoinclude><include file=\"robot.xml\"/></mujocoinclude>");
  EXPECT_EQ(error("<mujoco><include file=\"part.xml\"/></mujoco>"), "no error");
  EXPECT_NE(error("<mujoco><include file=\"nowhere.xml\"/></mujoco>").find("nowhere.xml"), std::string::npos);
  EXPECT_NE(error("<mujoco><include file=\"part.xml\"/><include file=\"part.xml\"/></mujoco>").find("twice"),
            std::string::npos);
  EXPECT_NE(error("<mujoco><include file=\"loop.xml\"/></mujoco>").find("twice"), std::string::npos);
  EXPECT_NE(error("<mujoco><include/></mujoco>").find("names no file"), std::string::npos);
  EXPECT_NE(error("<robot name=\"urdf\"/>").find("not MJCF"), std::string::npos);
  EXPECT_NE(error("<mujoco><worldbody></mujoco>").find("not valid XML"), std::string::npos);
  EXPECT_NE(error("").find("not"), std::string::npos);
}

TEST(RobotFile, AJointWithoutLimitsIsNamedWithTheRemedy) {
  const auto error = [](const std::string& from, const std::string& to) {
    const RobotFolder folder;
    write_robot(folder, {});
    std::string text = read_file(folder.path("robot.xml")).value();
    text.replace(text.find(from), from.size(), to);
    folder.put("robot.xml", text);
    return folder.error();
  };
  // A range alone is an error of MuJoCo's, which says what would be right.
  const std::string relied_on = error(" autolimits=\"true\"", "");
  EXPECT_NE(relied_on.find("autolimits=\"true\""), std::string::npos) << relied_on;
  EXPECT_NE(relied_on.find("j0"), std::string::npos) << relied_on;
  for (const char* range : {"", " limited=\"false\" range=\"-1.5 1.5\""}) {
    const std::string unlimited = error(" range=\"-1.5 1.5\"", range);
    EXPECT_NE(unlimited.find("arm[0]: joint 'j0' has no limits"), std::string::npos) << unlimited;
    EXPECT_NE(unlimited.find("limited=\"true\""), std::string::npos) << unlimited;
  }
}

TEST(RobotFile, WhatCannotBeAHandIsRefusedInWords) {
  const auto refused = [](const GeneratedRobot& about, const std::string& from, const std::string& to) {
    const RobotFolder folder;
    write_robot(folder, about);
    std::string text = read_file(folder.path("robot.yaml")).value();
    if (const auto at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
    folder.put("robot.yaml", text);
    return folder.error();
  };
  EXPECT_EQ(refused({}, "", ""), "no error");
  EXPECT_NE(refused({.fingers = 1}, "", "").find("fingertips: 1"), std::string::npos);
  EXPECT_NE(refused({.fingers = 6}, "", "").find("fingertips: 6"), std::string::npos);
  EXPECT_NE(refused({}, "body: finger0, position", "body: b3, position").find("fingertip 'tip0'"), std::string::npos);
  EXPECT_NE(refused({}, "{body: palm,", "{body: b0,").find("grasp_frame"), std::string::npos);
  EXPECT_NE(refused({}, "{body: palm,", "{").find("either a body or a site"), std::string::npos);
  EXPECT_NE(refused({}, "{body: palm,", "{site: palm,").find("no site 'palm'"), std::string::npos);
  EXPECT_NE(refused({}, "kp: 20,", "kp: 0,").find("closes, so it needs kp"), std::string::npos);
  EXPECT_NE(refused({}, "max_torque: 2}", "max_torque: 0.5}").find("max_torque"), std::string::npos);
  EXPECT_NE(refused({.arm = 2}, "joint: j0, control_weight: 0.2, home: 0.2", "joint: f0, home: 0").find("f0"),
            std::string::npos);
  // Swapped arm joints.
  EXPECT_NE(refused({.arm = 2}, "joint: j0", "joint: j1").find("j1"), std::string::npos);
}

}  // namespace
}  // namespace primo::robot

#include "robot/mjcf_features.h"

#include <tinyxml2.h>

#include <array>
#include <string_view>

namespace primo::robot {
namespace {

constexpr const char* kOwnIntegrator = "leave the option out: primo sets its own integrator";
constexpr const char* kWriteOut = "write the bodies out";
constexpr const char* kOwnDrives = "leave it out: primo drives the joints itself, with the robot file's kp and kd";
constexpr const char* kCompensated = "leave it out: primo's control compensates gravity";
constexpr const char* kOwnSizes = "leave the section out: primo sets the sizes";
constexpr const char* kFlexible = "only rigid bodies can be read";
constexpr const char* kNoPlugins =
    "there are no plugins; a robot is bodies, joints, geoms and joint or tendon equalities";
constexpr const char* kUseBodies = "name the bodies or joints that it couples instead";

constexpr std::array kFeatures = {
    MjcfFeature{"option", "integrator", "implicitfast", kOwnIntegrator},
    MjcfFeature{"size", "memory", "", kOwnSizes},
    MjcfFeature{"body", "gravcomp", "", kCompensated},
    MjcfFeature{"joint", "actuatorgravcomp", "", kCompensated},
    MjcfFeature{"joint", "actuatorfrcrange", "", "put the limit into the robot file's max_torque"},
    MjcfFeature{"joint", "actuatorfrclimited", "", "put the limit into the robot file's max_torque"},
    MjcfFeature{"position", "kv", "", kOwnDrives},
    MjcfFeature{"position", "dampratio", "", kOwnDrives},
    MjcfFeature{"position", "inheritrange", "", kOwnDrives},
    MjcfFeature{"position", "timeconst", "", kOwnDrives},
    MjcfFeature{"intvelocity", "inheritrange", "", kOwnDrives},
    MjcfFeature{"", "actearly", "", kOwnDrives},
    MjcfFeature{"frame", "", "", "write the frame's pose into each of its elements, or make it a body"},
    MjcfFeature{"replicate", "", "", kWriteOut},
    MjcfFeature{"attach", "", "", "include the other file's bodies with <include>"},
    MjcfFeature{"model", "", "", "include the other file's bodies with <include>"},
    MjcfFeature{"extension", "", "", kNoPlugins},
    MjcfFeature{"plugin", "", "", kNoPlugins},
    MjcfFeature{"flexcomp", "", "", kFlexible},
    MjcfFeature{"flex", "", "", kFlexible},
    MjcfFeature{"geom", "type", "sdf", "use a mesh or primitive shapes"},
    MjcfFeature{"connect", "site1", "", kUseBodies},
    MjcfFeature{"weld", "site1", "", kUseBodies},
    MjcfFeature{"mesh", "inertia", "", "write <inertial> into the body"},
    MjcfFeature{"mesh", "maxhullvert", "", "leave it out: primo covers colliding meshes with a primitive shape"},
    MjcfFeature{"mesh", "builtin", "", "use a primitive shape"},
    MjcfFeature{"mesh", "content_type", "", "leave it out: the file name's ending tells"},
    MjcfFeature{"texture", "content_type", "", "leave it out: the file name's ending tells"},
    MjcfFeature{"texture", "colorspace", "", "leave it out"},
    MjcfFeature{"layer", "", "", "name the texture in the material's texture attribute"},
    MjcfFeature{"compiler", "alignfree", "", "leave it out"},
    MjcfFeature{"compiler", "saveinertial", "", "leave it out"},
};

bool matches(const MjcfFeature& feature, const tinyxml2::XMLElement& element) {
  if (*feature.element && std::string_view(feature.element) != element.Name()) return false;
  if (!*feature.attribute) return true;
  const char* value = element.Attribute(feature.attribute);
  return value && (!*feature.value || std::string_view(feature.value) == value);
}

std::string named(const MjcfFeature& feature, const tinyxml2::XMLElement& element) {
  const std::string name = element.Name();
  if (!*feature.attribute) return "element <" + name + ">";
  const std::string attribute = std::string(feature.attribute) + "=\"" + element.Attribute(feature.attribute) + "\"";
  return "attribute " + attribute + " of element <" + name + ">";
}

Error at(const std::filesystem::path& file, const tinyxml2::XMLElement& element, const std::string& message) {
  return {Code::config, file.string() + ":" + std::to_string(element.GetLineNum()) + ": " + message};
}

/// What MuJoCo 2.2 reads but would not keep to the robot.
Status check_compiler(const tinyxml2::XMLElement& element, const std::filesystem::path& file) {
  if (std::string_view(element.Name()) != "compiler") return success();
  if (element.Attribute("settotalmass") && element.DoubleAttribute("settotalmass") > 0) {
    return at(file, element,
              "settotalmass of <compiler> would also weigh the objects around the robot; write the bodies' masses");
  }
  const char* coordinate = element.Attribute("coordinate");
  if (coordinate && std::string_view(coordinate) == "global")
    return at(file, element, "coordinate=\"global\" of <compiler> would also move the objects; use local coordinates");
  return success();
}

}  // namespace

std::span<const MjcfFeature> unread_features() { return kFeatures; }

Status check_features(const tinyxml2::XMLElement& root, const std::filesystem::path& file) {
  for (const auto& feature : kFeatures) {
    if (!matches(feature, root)) continue;
    return at(file, root,
              named(feature, root) + " belongs to a newer MuJoCo; MuJoCo 2.2 does not read it: " + feature.instead);
  }
  PRIMO_TRY(check_compiler(root, file));
  for (const auto* child = root.FirstChildElement(); child; child = child->NextSiblingElement())
    PRIMO_TRY(check_features(*child, file));
  return success();
}

}  // namespace primo::robot

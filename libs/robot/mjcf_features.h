// What newer MuJoCo versions write into MJCF and MuJoCo 2.2 does not read.
#pragma once

#include <filesystem>
#include <span>

#include "core/result.h"

namespace tinyxml2 {
class XMLElement;
}

namespace primo::robot {

/// A feature: an element, an attribute of it, or a value of the attribute. "" stands for any.
struct MjcfFeature {
  const char* element;
  const char* attribute;
  const char* value;
  const char* instead;  ///< what MuJoCo 2.2 reads, or why the feature can go
};

/// The table of features that are refused by name. What else MuJoCo 2.2 does not know, it refuses itself, with the
/// line.
std::span<const MjcfFeature> unread_features();

/// Refuses the first feature of the table in `root` or below, naming feature, element, file and line; also what would
/// change the scene that the robot is put into (settotalmass, global coordinates).
Status check_features(const tinyxml2::XMLElement& root, const std::filesystem::path& file);

}  // namespace primo::robot

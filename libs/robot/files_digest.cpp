#include "robot/files_digest.h"

#include <tinyxml2.h>

#include <cstring>

#include "core/files.h"
#include "core/hash.h"
#include "robot/mjcf.h"

namespace primo::robot {
namespace {

namespace fs = std::filesystem;

/// Where assets are looked up: the <compiler> attributes, a later one instead of an earlier one, as MuJoCo reads them.
struct Folders {
  fs::path meshes, textures;
  bool strip = false;
  explicit Folders(const tinyxml2::XMLElement& root) {
    for (auto* c = root.FirstChildElement("compiler"); c; c = c->NextSiblingElement("compiler")) {
      if (const char* text = c->Attribute("meshdir")) meshes = text;
      if (const char* text = c->Attribute("texturedir")) textures = text;
      if (const char* text = c->Attribute("strippath")) strip = std::strcmp(text, "true") == 0;
    }
  }
  fs::path find(const fs::path& model, const char* element, const fs::path& file) const {
    const bool picture = std::strcmp(element, "texture") == 0;
    return model.parent_path() / (picture ? textures : meshes) / (strip ? file.filename() : file);
  }
};

}  // namespace

Result<std::string> files_digest(const fs::path& robot_file, const fs::path& mjcf) {
  Hasher hasher;
  PRIMO_ASSIGN(const std::string robot, read_file(robot_file));
  PRIMO_ASSIGN(const std::string model, read_mjcf(mjcf));
  hasher.add(robot).add(model);
  tinyxml2::XMLDocument document;
  if (document.Parse(("<mujoco>" + model + "</mujoco>").c_str()) != tinyxml2::XML_SUCCESS)
    return Error{Code::config, mjcf.string() + ": not valid XML: " + document.ErrorName()};
  const auto& root = *document.RootElement();
  const Folders folders(root);
  for (auto* assets = root.FirstChildElement("asset"); assets; assets = assets->NextSiblingElement("asset")) {
    for (auto* asset = assets->FirstChildElement(); asset; asset = asset->NextSiblingElement()) {
      const char* file = asset->Attribute("file");
      if (!file || !*file) continue;
      PRIMO_ASSIGN(const std::string content, read_file(folders.find(mjcf, asset->Name(), file)));
      hasher.add(content);
    }
  }
  return hex(hasher.value());
}

}  // namespace primo::robot

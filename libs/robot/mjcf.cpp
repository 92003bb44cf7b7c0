#include "robot/mjcf.h"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <array>
#include <charconv>
#include <cstring>
#include <initializer_list>
#include <mutex>
#include <set>
#include <string_view>

#include "core/files.h"
#include "robot/mesh_cover.h"
#include "robot/mjcf_features.h"
#include "robot/mjcf_refusal.h"

namespace primo::robot {
namespace {

constexpr std::size_t kMostBytes = 32U << 20U;  // of one file
constexpr std::size_t kMostFiles = 64;
constexpr std::array kSetByPrimo = {"option",  "size",   "keyframe", "actuator",  "sensor",
                                    "contact", "custom", "visual",   "statistic", "deformable"};

Error refuse(const std::string& place, const std::string& message) { return {Code::config, place + ": " + message}; }

/// Reads a file and those it includes into one document.
class Flattener {
 public:
  explicit Flattener(const std::filesystem::path& path) : directory_(path.parent_path()) {}

  Status read(const std::filesystem::path& path, tinyxml2::XMLDocument& document) {
    if (!files_.insert(path.lexically_normal().string()).second)
      return refuse(path.string(), "included twice; MuJoCo includes a file once");
    if (files_.size() > kMostFiles) return refuse(path.string(), "more than 64 files include each other");
    PRIMO_ASSIGN(const std::string text, read_file(path));
    if (text.size() > kMostBytes) return refuse(path.string(), "larger than 32 MB");
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      return refuse(path.string() + ":" + std::to_string(document.ErrorLineNum()),
                    std::string("not valid XML: ") + document.ErrorName());
    }
    auto* root = document.RootElement();
    const std::string name = root ? root->Name() : "";
    if (name != "mujoco" && name != "mujocoinclude")
      return refuse(path.string(), "not MJCF: its root is <" + name + ">, must be <mujoco>");
    PRIMO_TRY(check_features(*root, path));
    return include_into(*root, path);
  }

  /// Names for what has none, so that the same body is found again in every model it becomes part of.
  void name_all(tinyxml2::XMLElement& element) {
    for (auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
      const bool body = std::strcmp(child->Name(), "body") == 0, joint = std::strcmp(child->Name(), "joint") == 0;
      if ((body || joint) && !child->Attribute("name"))
        child->SetAttribute("name", ("primo:" + std::string(child->Name()) + std::to_string(++unnamed_)).c_str());
      if (body) name_all(*child);
    }
  }

 private:
  Status include_into(tinyxml2::XMLElement& element, const std::filesystem::path& path) {
    for (auto* child = element.FirstChildElement(); child;) {
      auto* next = child->NextSiblingElement();
      if (std::strcmp(child->Name(), "include") != 0) {
        PRIMO_TRY(include_into(*child, path));
      } else {
        const char* file = child->Attribute("file");
        const std::string place = path.string() + ":" + std::to_string(child->GetLineNum());
        if (!file || !*file) return refuse(place, "<include> names no file");
        tinyxml2::XMLDocument included;
        if (auto status = read(directory_ / file, included); !status.ok()) return status.error().at(place);
        tinyxml2::XMLNode* after = child;
        for (auto* part = included.RootElement()->FirstChild(); part; part = part->NextSibling())
          after = element.InsertAfterChild(after, part->DeepClone(element.GetDocument()));
        element.DeleteChild(child);
      }
      child = next;
    }
    return success();
  }

  const std::filesystem::path directory_;  // of the model: where every include is looked up
  std::set<std::string> files_;
  int unnamed_ = 0;
};

// MuJoCo's defaults write MUJOCO_LOG.TXT into the working directory and end the process. Warnings are read from mjData
// instead.
void ignore_warning(const char*) {}
void stop_on_error(const char* message) { check_failed("MuJoCo", "mujoco", 0, message); }

void install_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_warning = ignore_warning;
    mju_user_error = stop_on_error;
  });
}

/// The compiler keeps the last model in a global, sets the locale and other globals of the process.
std::mutex& compiler_mutex() {
  static std::mutex mutex;
  return mutex;
}

struct VfsDeleter {
  void operator()(mjVFS* vfs) const {
    mj_deleteVFS(vfs);
    delete vfs;
  }
};

Status add_file(mjVFS* vfs, const std::string& name, const std::string& text) {
  if (mj_makeEmptyFileVFS(vfs, name.c_str(), static_cast<int>(text.size())) != 0) {
    return Error{Code::internal, "cannot put " + name + " into MuJoCo's file system"};
  }
  std::memcpy(vfs->filedata[mj_findFileVFS(vfs, name.c_str())], text.data(), text.size());
  return success();
}

/// Numbers as text that reads back to the same bits.
std::string exact(std::initializer_list<double> values) {
  std::string text;
  std::array<char, 40> buffer{};
  for (const double value : values) {
    if (!text.empty()) text += ' ';
    text.append(buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr);
  }
  return text;
}

}  // namespace

std::string name_of(const mjModel& model, mjtObj type, int id) {
  const char* given = mj_id2name(&model, type, id);
  std::string name = given ? given : "";
  if (name.empty()) name.append("#").append(std::to_string(id));
  return name;
}

namespace {

/// Lights and cameras of the robot's own: they would change how the scene is lit, not what happens in it.
void leave_out_look(tinyxml2::XMLElement& body) {
  for (auto* child = body.FirstChildElement(); child;) {
    auto* next = child->NextSiblingElement();
    const std::string_view name = child->Name();
    if (name == "light" || name == "camera") {
      body.DeleteChild(child);
    } else {
      leave_out_look(*child);
    }
    child = next;
  }
}

/// Puts what the world's sections hold into one body at X_WM.
void stand_at(const Pose& X_WM, tinyxml2::XMLElement& root) {
  tinyxml2::XMLElement* base = nullptr;
  for (auto* world = root.FirstChildElement("worldbody"); world; world = world->NextSiblingElement("worldbody")) {
    auto* part = world->FirstChild();
    if (!base) {
      base = world->InsertNewChildElement("body");
      base->SetAttribute("name", "primo:base");
      const Eigen::Vector3d p = X_WM.translation();
      const Eigen::Quaterniond q(X_WM.linear());
      base->SetAttribute("pos", exact({p.x(), p.y(), p.z()}).c_str());
      base->SetAttribute("quat", exact({q.w(), q.x(), q.y(), q.z()}).c_str());
    }
    while (part) {
      auto* next = part->NextSibling();
      if (part != base) base->InsertEndChild(part);
      part = next;
    }
  }
}

}  // namespace

Result<std::string> read_mjcf(const std::filesystem::path& path, const Pose& X_WM) {
  Flattener flattener(path);
  tinyxml2::XMLDocument document;
  PRIMO_TRY(flattener.read(path, document));
  auto& root = *document.RootElement();
  for (const char* name : kSetByPrimo) {
    while (auto* section = root.FirstChildElement(name)) root.DeleteChild(section);
  }
  for (auto* world = root.FirstChildElement("worldbody"); world; world = world->NextSiblingElement("worldbody")) {
    leave_out_look(*world);
    flattener.name_all(*world);
  }
  if (!X_WM.matrix().isIdentity(0)) stand_at(X_WM, root);
  tinyxml2::XMLPrinter printer(nullptr, true);
  for (auto* part = root.FirstChildElement(); part; part = part->NextSiblingElement()) part->Accept(&printer);
  return std::string(printer.CStr());
}

Result<ModelPointer> compile_mjcf(const std::string& mjcf, const std::filesystem::path& directory,
                                  const std::string& what) {
  install_handlers();
  const std::lock_guard lock(compiler_mutex());
  std::unique_ptr<mjVFS, VfsDeleter> vfs(new mjVFS);
  mj_defaultVFS(vfs.get());
  constexpr const char* kName = "primo_assembled.xml";
  PRIMO_TRY(add_file(vfs.get(), kName, mjcf));
  std::array<char, 1000> message{};
  ModelPointer model(
      mj_loadXML((directory / kName).string().c_str(), vfs.get(), message.data(), static_cast<int>(message.size())));
  if (!model) return Error{Code::config, what + ": MuJoCo refuses the model: " + message.data()};
  return model;
}

Result<ModelPointer> compile_robot(const std::string& sections, const std::filesystem::path& path) {
  auto model = compile_mjcf("<mujoco>" + sections + "</mujoco>", path.parent_path(), path.string());
  if (!model.ok()) {
    // The same from the file itself: its message counts the file's lines.
    const std::lock_guard lock(compiler_mutex());
    std::array<char, 1000> message{};
    const ModelPointer again(mj_loadXML(path.c_str(), nullptr, message.data(), static_cast<int>(message.size())));
    if (again) return model.error();
    return Error{Code::config, refusal(path, message.data())};
  }
  PRIMO_TRY(cover_meshes(**model, path.string()));
  return model;
}

}  // namespace primo::robot

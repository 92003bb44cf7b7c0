#include "robot/mjcf_refusal.h"

#include <mujoco/mujoco.h>
#include <tinyxml2.h>

#include <cstdlib>
#include <cstring>
#include <optional>
#include <set>

#include "core/files.h"

namespace primo::robot {
namespace {

/// What stands after `before` in `text`, up to `end`.
std::string between(const std::string& text, const std::string& before, char end) {
  const auto at = text.find(before);
  if (at == std::string::npos) return {};
  const auto from = at + before.size();
  return text.substr(from, text.find(end, from) - from);
}

std::string at_line(const std::filesystem::path& file, int line) { return file.string() + ":" + std::to_string(line); }

/// Looks through included files for an element with an attribute ("": with any).
class Search {
 public:
  Search(std::filesystem::path directory, std::string element, std::string attribute)
      : directory_(std::move(directory)), element_(std::move(element)), attribute_(std::move(attribute)) {}

  std::optional<std::string> in_file(const std::filesystem::path& file, bool included) {
    const auto text = read_file(file);
    tinyxml2::XMLDocument document;
    if (!seen_.insert(file.lexically_normal().string()).second || !text.ok() ||
        document.Parse(text->data(), text->size()) != tinyxml2::XML_SUCCESS)
      return std::nullopt;
    return below(*document.RootElement(), file, included);
  }

 private:
  std::optional<std::string> below(const tinyxml2::XMLElement& parent, const std::filesystem::path& file,
                                   bool included) {
    for (const auto* child = parent.FirstChildElement(); child; child = child->NextSiblingElement()) {
      const bool named = included && element_ == child->Name();
      if (named && (attribute_.empty() || child->Attribute(attribute_.c_str())))
        return at_line(file, child->GetLineNum());
      const char* include = std::strcmp(child->Name(), "include") == 0 ? child->Attribute("file") : nullptr;
      auto found = include ? in_file(directory_ / include, true) : below(*child, file, included);
      if (found) return found;
    }
    return std::nullopt;
  }

  const std::filesystem::path directory_;  // of the model: where every include is looked up
  const std::string element_, attribute_;
  std::set<std::string> seen_;
};

}  // namespace

std::string refusal(const std::filesystem::path& path, const std::string& message) {
  const std::string version = mj_versionString(), hint = " (docs/robots.md says what it reads)";
  const std::string element = between(message, "Element '", '\''),
                    attribute = between(message, "unrecognized attribute: '", '\'');
  const bool unknown = !attribute.empty() || message.find("unrecognized element") != std::string::npos;
  if (unknown && !element.empty()) {
    const int line = std::atoi(between(message, ", line ", '\n').c_str());
    std::string place = line > 0 ? at_line(path, line) : path.string();
    // MuJoCo counts no lines in what it included.
    if (line == 0) place = Search(path.parent_path(), element, attribute).in_file(path, false).value_or(place);
    const std::string what = (attribute.empty() ? "" : "attribute " + attribute + " of ") + "element <" + element + ">";
    return place + ": MuJoCo " + version + " does not know " + what + hint;
  }
  std::string sentence = message;
  for (char& c : sentence) c = c == '\n' ? ' ' : c;
  return path.string() + ": not a model that MuJoCo " + version + " can read: " + sentence + hint;
}

}  // namespace primo::robot

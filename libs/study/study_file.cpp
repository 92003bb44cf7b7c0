// Study files as people write them, made complete.
#include <algorithm>
#include <utility>

#include "core/hash.h"
#include "robot/robot.h"
#include "scene/reach.h"
#include "study/study.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepestInclude = 8;

/// A part as it stands in a study file.
struct PartFile {
  std::string name, primitive, structure;
  std::vector<std::string> training;
  StudySettings settings;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "of the part; letters, digits, _ and -"});
    v("primitive", primitive, {.help = "file of the hand-tuned primitive P", .required = true});
    v("structure", structure,
      {.help =
           "file of another primitive of the action, whose open entries are searched instead of P's; empty: P's own"});
    v("training", training, {.help = "files of the training scenarios", .required = true});
    settings.visit(v);
  }
  Status validate() const { return settings.validate(); }
};

struct Heading {
  std::string name, robot;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.help = "letters, digits, _ and -", .required = true});
    v("robot", robot, {.help = "robot file, relative to this one", .required = true});
  }
};

/// The node's entry, or an undefined one; never adds it.
YAML::Node entry(const YAML::Node& node, const std::string& key) {
  return node.IsMap() ? node[key] : YAML::Node(YAML::NodeType::Undefined);
}

/// `over` on top of `under`: maps key by key, anything else whole. Neither is changed.
YAML::Node merged(const YAML::Node& under, const YAML::Node& over) {
  if (!over.IsDefined()) return under;
  if (!under.IsDefined() || !under.IsMap() || !over.IsMap()) return over;
  // An entry is set once: setting it again would change the node that it shares with `under`.
  YAML::Node out(YAML::NodeType::Map);
  for (const auto& one : under) {
    const auto key = one.first.Scalar();
    out[key] = merged(one.second, entry(over, key));
  }
  for (const auto& one : over) {
    if (!entry(under, one.first.Scalar()).IsDefined()) out[one.first.Scalar()] = one.second;
  }
  return out;
}

YAML::Node without(const YAML::Node& node, const std::vector<std::string>& keys) {
  YAML::Node out(YAML::NodeType::Map);
  for (const auto& one : node) {
    const auto key = one.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) out[key] = one.second;
  }
  return out;
}

/// The map with its file names, which are relative to the file it stands in, as paths from here. A new map: what YAML
/// aliases name is shared between places.
YAML::Node with_paths(const YAML::Node& node, const fs::path& folder) {
  if (!node.IsMap()) return node;
  const auto path = [&](const YAML::Node& name) {
    return name.IsScalar() ? YAML::Node((folder / name.Scalar()).lexically_normal().string()) : name;
  };
  YAML::Node out(YAML::NodeType::Map);
  for (const auto& one : node) {
    const auto key = one.first.Scalar();
    YAML::Node value;
    value.reset(key == "robot" || key == "primitive" || key == "structure" ? path(one.second) : one.second);
    if (one.second.IsSequence() && (key == "training" || key == "parts")) {
      value.reset(YAML::Node(YAML::NodeType::Sequence));
      for (const auto& element : one.second)
        value.push_back(key == "parts" ? with_paths(element, folder) : path(element));
    }
    out[key] = value;
  }
  return out;
}

/// The file with what it includes.
Result<YAML::Node> read_tree(const fs::path& file, int depth) {
  const std::string where = file.string();
  if (depth > kDeepestInclude) {
    return Error{Code::config, where + ": includes go deeper than " + std::to_string(kDeepestInclude) +
                                   "; does a file include itself?"};
  }
  PRIMO_ASSIGN(const std::string text, read_file(file));
  PRIMO_ASSIGN(YAML::Node node, config::detail::parse(text, where));
  if (!node.IsMap()) return Error{Code::config, where + ": must be a map of keys to values"};
  node.reset(with_paths(node, file.parent_path()));
  const YAML::Node include = entry(node, "include");
  if (!include.IsDefined()) return node;
  std::vector<std::string> names;
  if (include.IsScalar()) names.push_back(include.Scalar());
  if (include.IsSequence()) {
    for (const auto& name : include) names.push_back(name.IsScalar() ? name.Scalar() : "");
  }
  if (names.empty() || std::count(names.begin(), names.end(), "") > 0)
    return Error{Code::config, where + ": 'include' must be a file name or a list of them"};
  YAML::Node under(YAML::NodeType::Undefined);
  for (const auto& name : names) {
    auto included = read_tree(file.parent_path() / name, depth + 1);
    if (!included) return included.error().at("included by " + where);
    under.reset(merged(under, *included));
  }
  return merged(under, without(node, {"include"}));
}

Result<std::vector<scene::Scenario>> read_training(const std::vector<std::string>& files, const robot::Robot& robot) {
  std::vector<scene::Scenario> training;
  for (const auto& name : files) {
    PRIMO_ASSIGN(auto scenario, scene::read_scenario(name));
    if (auto status = scene::check_robot(scenario, robot); !status.ok()) return status.error().at(name);
    if (scenario.robot_start.empty()) scenario.robot_start.assign(robot.home().begin(), robot.home().end());
    training.push_back(std::move(scenario));
  }
  return training;
}

/// What the command line says of all parts, and of single ones.
struct Overrides {
  YAML::Node heading, all;
  std::map<std::string, YAML::Node> of_part;
};

Result<Overrides> sort_overrides(const std::vector<std::string>& assignments, const std::vector<std::string>& parts) {
  std::vector<std::string> heading, all;
  std::map<std::string, std::vector<std::string>> of_part;
  for (const auto& assignment : assignments) {
    const auto first = assignment.substr(0, assignment.find_first_of(".="));
    if (first == "parts" || first == "include") {
      return Error{Code::usage, "override '" + assignment + "': parts are addressed by their names, e.g. " +
                                    (parts.empty() ? "grasp" : parts.front()) + ".optimizer.evaluations=500"};
    }
    const bool dotted = assignment.find('.') < assignment.find('=');
    if (dotted && std::find(parts.begin(), parts.end(), first) != parts.end()) {
      of_part[first].push_back(assignment.substr(first.size() + 1));
    } else {
      (first == "name" || first == "robot" ? heading : all).push_back(assignment);
    }
  }
  Overrides out;
  PRIMO_ASSIGN(out.heading, config::override_keys(YAML::Node(YAML::NodeType::Map), heading));
  PRIMO_ASSIGN(out.all, config::override_keys(YAML::Node(YAML::NodeType::Map), all));
  for (const auto& [part, own] : of_part) {
    PRIMO_ASSIGN(out.of_part[part], config::override_keys(YAML::Node(YAML::NodeType::Map), own));
  }
  return out;
}

/// The maps of the parts, each with what stands beside them.
Result<std::vector<YAML::Node>> part_nodes(const YAML::Node& tree, const std::string& where) {
  const YAML::Node common = without(tree, {"name", "robot", "parts"});
  const YAML::Node listed = entry(tree, "parts");
  if (!listed.IsDefined()) return std::vector<YAML::Node>{common};
  if (!listed.IsSequence() || listed.size() == 0)
    return Error{Code::config, where + ": 'parts' must be a list with at least one map"};
  std::vector<YAML::Node> nodes;
  for (const auto& part : listed) {
    if (!part.IsMap()) return Error{Code::config, where + ": an entry of 'parts' is not a map of keys to values"};
    nodes.push_back(merged(common, part));
  }
  return nodes;
}

Result<Part> read_part(const YAML::Node& node, const std::string& where, const robot::Robot& robot) {
  PRIMO_ASSIGN(const PartFile file, config::read_node<PartFile>(node, where));
  Part part;
  part.settings = file.settings;
  PRIMO_ASSIGN(part.primitive, motion::read_primitive(file.primitive));
  if (!file.structure.empty()) {
    PRIMO_ASSIGN(part.structure, motion::read_primitive(file.structure));
  }
  PRIMO_ASSIGN(part.training, read_training(file.training, robot));
  part.name = file.name.empty() ? part.primitive.action : file.name;
  return part;
}

}  // namespace

std::string describe_study_file() {
  return "# include: a study file, or a list of them, whose keys hold where this one does not say otherwise\n" +
         config::describe<Heading>() +
         "# parts: a list of maps with the keys below; what stands beside it holds for all of them\n" +
         config::describe<PartFile>();
}

Result<Study> load_study(const fs::path& study_file, const std::vector<std::string>& overrides) {
  const std::string where = study_file.string();
  PRIMO_ASSIGN(const YAML::Node tree, read_tree(study_file, 0));
  PRIMO_ASSIGN(const auto nodes, part_nodes(tree, where));
  std::vector<std::string> names;
  for (const auto& node : nodes) {
    const YAML::Node name = entry(node, "name");
    if (name.IsDefined() && name.IsScalar()) names.push_back(name.Scalar());
  }
  PRIMO_ASSIGN(const Overrides given, sort_overrides(overrides, names));

  YAML::Node head(YAML::NodeType::Map);
  for (const char* key : {"name", "robot"}) {
    if (const YAML::Node value = entry(tree, key); value.IsDefined()) head[key] = value;
  }
  PRIMO_ASSIGN(const Heading heading, config::read_node<Heading>(merged(head, given.heading), where));
  Study study;
  study.name = heading.name;
  study.robot = fs::absolute(heading.robot).lexically_normal().string();
  PRIMO_ASSIGN(const robot::Robot robot, robot::Robot::load(study.robot));
  PRIMO_ASSIGN(const std::string robot_text, read_file(study.robot));
  PRIMO_ASSIGN(const std::string model_text, read_file(robot.mjcf_path()));
  study.robot_digest = hex(Hasher().add(robot_text).add(model_text).value());
  for (const auto& node : nodes) {
    YAML::Node whole(merged(node, given.all));
    const YAML::Node name = entry(node, "name");
    if (name.IsDefined() && name.IsScalar()) {
      if (const auto own = given.of_part.find(name.Scalar()); own != given.of_part.end())
        whole.reset(merged(whole, own->second));
    }
    PRIMO_ASSIGN(auto part, read_part(whole, where, robot));
    study.parts.push_back(std::move(part));
  }
  if (auto status = study.validate(); !status.ok()) return status.error().at(where);
  return study;
}

}  // namespace primo::study

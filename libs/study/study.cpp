#include "study/study.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "core/hash.h"
#include "robot/files_digest.h"
#include "robot/robot.h"
#include "scene/reach.h"
#include "symbols/literal_json.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

fs::path study_yaml(const fs::path& directory) { return directory / "study.yaml"; }

Status check_name(const std::string& name) {
  const bool good = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  if (good) return success();
  return Error{Code::config, "'name' is '" + name + "', must be 1 to 64 letters, digits, _ and -"};
}

/// Every leaf of a YAML tree by its path, "optimizer.sigma" or "training[2].objects[0].position[1]".
void flatten(const YAML::Node& node, const std::string& path, std::map<std::string, std::string>& leaves) {
  if (node.IsMap()) {
    for (const auto& entry : node) {
      const auto key = entry.first.Scalar();
      flatten(entry.second, path.empty() ? key : path + "." + key, leaves);
    }
  } else if (node.IsSequence()) {
    for (std::size_t i = 0; i < node.size(); ++i) flatten(node[i], path + "[" + std::to_string(i) + "]", leaves);
    if (node.size() == 0) leaves[path] = "[]";
  } else {
    leaves[path] = node.IsScalar() ? node.Scalar() : "~";
  }
}

Result<std::map<std::string, std::string>> leaves_of(const std::string& text, const std::string& where) {
  PRIMO_ASSIGN(const YAML::Node node, config::detail::parse(text, where));
  std::map<std::string, std::string> leaves;
  flatten(node, "", leaves);
  leaves.erase("robot");  // where the file lies does not matter, its digest does
  return leaves;
}

/// The first key in which two complete studies differ, with both values; empty when they are the same.
Result<std::string> difference(const std::string& there, const std::string& here, const std::string& where) {
  PRIMO_ASSIGN(const auto old_leaves, leaves_of(there, where));
  PRIMO_ASSIGN(const auto new_leaves, leaves_of(here, "study"));
  std::set<std::string> keys;
  for (const auto& [key, value] : old_leaves) keys.insert(key);
  for (const auto& [key, value] : new_leaves) keys.insert(key);
  const auto value_in = [](const auto& leaves, const std::string& key) {
    const auto at = leaves.find(key);
    return at == leaves.end() ? std::string("(nothing)") : at->second;
  };
  for (const auto& key : keys) {
    const auto old_value = value_in(old_leaves, key), new_value = value_in(new_leaves, key);
    if (old_value != new_value) return "'" + key + "' is " + old_value + " there and " + new_value + " now";
  }
  return std::string();
}

Result<std::vector<scene::Scenario>> read_training(const StudyFile& file, const fs::path& folder,
                                                   const robot::Robot& robot) {
  std::vector<scene::Scenario> training;
  for (const auto& name : file.training) {
    PRIMO_ASSIGN(auto scenario, scene::read_scenario(folder / name));
    if (auto status = scene::check_robot(scenario, robot); !status.ok())
      return status.error().at((folder / name).string());
    if (scenario.robot_start.empty()) scenario.robot_start.assign(robot.home().begin(), robot.home().end());
    training.push_back(std::move(scenario));
  }
  return training;
}

}  // namespace

Status StudySettings::validate() const {
  if (experience.seed == seed) {
    return Error{Code::config,
                 "'experience.seed' is " + std::to_string(seed) +
                     ", the same as 'seed'; experience must come from other random numbers than the optimization"};
  }
  if (optimizer.algorithms.empty()) {
    return Error{Code::config,
                 "'optimizer.algorithms' is empty; known ones: " + config::detail::joined(optim::optimizer_names())};
  }
  std::set<std::string> seen;
  for (const auto& algorithm : optimizer.algorithms) {
    const auto known = optim::optimizer_names();
    if (std::find(known.begin(), known.end(), algorithm) == known.end()) {
      return Error{Code::config,
                   "'optimizer.algorithms' has '" + algorithm + "'; known ones: " + config::detail::joined(known)};
    }
    if (!seen.insert(algorithm).second)
      return Error{Code::config, "'optimizer.algorithms' has '" + algorithm + "' twice"};
  }
  for (const auto& literal : goal) {
    if (literal.empty() || literal.size() > symbols::kMaxArity + 2) {
      return Error{Code::config, "'goal' has a literal of " + std::to_string(literal.size()) +
                                     " words; expected a predicate and its arguments, e.g. [inhand, X]"};
    }
  }
  if (executed > experience.scenarios) {
    return Error{Code::config, "'executed' is " + std::to_string(executed) +
                                   ", must be at most 'experience.scenarios', " + std::to_string(experience.scenarios)};
  }
  return optimizer.settings.validate();
}

Status StudyFile::validate() const {
  PRIMO_TRY(check_name(name));
  if (training.empty()) return Error{Code::config, "'training' is empty; at least one scenario is needed"};
  return settings.validate();
}

std::string Study::id() const {
  Study content = *this;
  content.robot.clear();
  return name + "-" + content_id(config::dump(content)).substr(0, 8);
}

Status Study::validate() const {
  PRIMO_TRY(check_name(name));
  PRIMO_TRY(settings.validate());
  if (auto status = primitive.validate(); !status.ok()) return status.error().at("primitive");
  if (training.empty()) return Error{Code::config, "'training' is empty; at least one scenario is needed"};
  std::set<std::string> names;
  for (const auto& scenario : training) {
    if (auto status = scenario.validate(); !status.ok()) return status.error().at("training scenario " + scenario.name);
    if (!names.insert(scenario.name).second)
      return Error{Code::config, "two training scenarios are named '" + scenario.name + "'"};
    if (scenario.action.front() != primitive.action) {
      return Error{Code::config, "training scenario '" + scenario.name + "' has the action '" +
                                     scenario.action.front() + "', but the primitive '" + primitive.name + "' is of '" +
                                     primitive.action + "'"};
    }
  }
  return success();
}

Result<Study> load_study(const fs::path& study_file, const std::vector<std::string>& overrides) {
  const std::string where = study_file.string();
  PRIMO_ASSIGN(const std::string text, read_file(study_file));
  PRIMO_ASSIGN(const YAML::Node parsed, config::detail::parse(text, where));
  PRIMO_ASSIGN(const YAML::Node node, config::override_keys(parsed, overrides));
  PRIMO_ASSIGN(const StudyFile file, config::read_node<StudyFile>(node, where));

  const fs::path folder = study_file.parent_path();
  Study study;
  study.name = file.name;
  study.settings = file.settings;
  study.robot = fs::absolute(folder / file.robot).lexically_normal().string();
  PRIMO_ASSIGN(const robot::Robot robot, robot::Robot::load(study.robot));
  PRIMO_ASSIGN(study.robot_digest, robot::files_digest(study.robot, robot.mjcf_path()));
  PRIMO_ASSIGN(study.primitive, motion::read_primitive(folder / file.primitive));
  PRIMO_ASSIGN(study.training, read_training(file, folder, robot));
  if (auto status = study.validate(); !status.ok()) return status.error().at(where);
  return study;
}

Result<Study> read_study(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::exists(study_yaml(directory), ignored)) {
    return Error{Code::config, directory.string() + ": has no study.yaml; is this a study's directory?"};
  }
  return config::read<Study>(study_yaml(directory));
}

Result<Adopted> adopt_directory(const Study& study, const fs::path& directory) {
  const fs::path file = study_yaml(directory);
  std::error_code failure;
  fs::create_directories(directory, failure);
  if (failure) return Error{Code::config, directory.string() + ": cannot be created: " + failure.message()};
  const std::string text = config::dump(study);
  if (!fs::exists(file, failure)) {
    if (fs::exists(directory / "journal.db", failure)) {
      return Error{Code::config, directory.string() +
                                     ": has a journal.db but no study.yaml, so it cannot be told whose it is; "
                                     "give another directory"};
    }
    PRIMO_TRY(write_file(file, text));
    return Adopted::created;
  }
  PRIMO_ASSIGN(const std::string there, read_file(file));
  PRIMO_ASSIGN(const std::string different, difference(there, text, file.string()));
  if (!different.empty()) {
    return Error{Code::config, directory.string() + ": holds another study: " + different +
                                   "; give another directory, or the study's own file"};
  }
  return Adopted::resumed;
}

}  // namespace primo::study

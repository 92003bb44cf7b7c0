#include "study/study.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "core/hash.h"
#include "symbols/literal.h"

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

/// Of two complete studies' texts.
Result<std::vector<Distinct>> differences_of(const std::string& first, const std::string& second,
                                             const std::string& where) {
  PRIMO_ASSIGN(const auto first_leaves, leaves_of(first, where));
  PRIMO_ASSIGN(const auto second_leaves, leaves_of(second, "study"));
  std::set<std::string> keys;
  for (const auto& [key, value] : first_leaves) keys.insert(key);
  for (const auto& [key, value] : second_leaves) keys.insert(key);
  const auto value_in = [](const auto& leaves, const std::string& key) {
    const auto at = leaves.find(key);
    return at == leaves.end() ? std::string("(nothing)") : at->second;
  };
  std::vector<Distinct> found;
  for (const auto& key : keys) {
    const auto one = value_in(first_leaves, key), other = value_in(second_leaves, key);
    if (one != other) found.push_back({key, one, other});
  }
  return found;
}

}  // namespace

Status GeneralizationSettings::validate() const {
  if (!levels.empty() && executed > scenarios) {
    return Error{Code::config, "'generalization.executed' is " + std::to_string(executed) +
                                   ", must be at most 'generalization.scenarios', " + std::to_string(scenarios)};
  }
  if (std::adjacent_find(levels.begin(), levels.end(), std::greater_equal<>()) != levels.end())
    return Error{Code::config, "'generalization.levels' must rise"};
  for (const double table : tables) {
    if (std::find(levels.begin(), levels.end(), table) == levels.end()) {
      return Error{Code::config, "'generalization.tables' has " + config::detail::format(table) +
                                     ", which is none of 'generalization.levels'"};
    }
  }
  return success();
}

Status StudySettings::validate() const {
  std::vector<std::pair<std::string, std::uint64_t>> seeds = {{"seed", seed}, {"experience.seed", experience.seed}};
  if (protocol == Protocol::robust) {
    seeds.insert(seeds.begin() + 1, {{"pool.seed", pool.seed}, {"pool.validation_seed", pool.validation_seed}});
    if (pool.drawn > pool.scenarios) {
      return Error{Code::config, "'pool.drawn' is " + std::to_string(pool.drawn) +
                                     ", must be at most 'pool.scenarios', " + std::to_string(pool.scenarios)};
    }
  }
  if (!generalization.levels.empty()) seeds.emplace_back("generalization.seed", generalization.seed);
  PRIMO_TRY(check_distinct_seeds(seeds));
  PRIMO_TRY(generalization.validate());
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

Status Part::validate() const {
  PRIMO_TRY(check_name(name));
  PRIMO_TRY(settings.validate());
  if (auto status = primitive.validate(); !status.ok()) return status.error().at("primitive");
  if (structure) {
    if (auto status = structure->validate(); !status.ok()) return status.error().at("structure");
    if (structure->action != primitive.action) {
      return Error{Code::config, "'structure' is the primitive '" + structure->name + "' of the action '" +
                                     structure->action + "', but 'primitive' is of '" + primitive.action + "'"};
    }
  }
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

std::string Study::id() const {
  Study content = *this;
  content.robot.clear();
  return name + "-" + content_id(config::dump(content)).substr(0, 8);
}

Status Study::validate() const {
  PRIMO_TRY(check_name(name));
  if (parts.empty()) return Error{Code::config, "'parts' is empty; at least one part is needed"};
  std::set<std::string> names;
  for (const auto& part : parts) {
    if (auto status = part.validate(); !status.ok())
      return parts.size() > 1 ? status.error().at("part " + part.name) : status.error();
    if (!names.insert(part.name).second)
      return Error{Code::config, "two parts are named '" + part.name + "'; give each a 'name' of its own"};
  }
  return success();
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
  PRIMO_ASSIGN(const auto different, differences_of(there, text, file.string()));
  if (!different.empty()) {
    const Distinct& first = different.front();
    return Error{Code::config, directory.string() + ": holds another study: '" + first.key + "' is " + first.first +
                                   " there and " + first.second +
                                   " now; give another directory, or the study's own file"};
  }
  return Adopted::resumed;
}

Result<std::vector<Distinct>> differences(const Study& first, const Study& second) {
  return differences_of(config::dump(first), config::dump(second), "study");
}

}  // namespace primo::study

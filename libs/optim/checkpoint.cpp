#include "optim/checkpoint.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/hash.h"

namespace primo::optim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;  // its keys are in alphabetical order

constexpr const char* kFormat = "primo optimizer checkpoint, version 2";
constexpr std::size_t kLargestText = 256 << 20;
constexpr int kDeepest = 4;

struct SettingsWriter {
  Json json = Json::object();
  template <class T>
  void operator()(const char* name, T& value, const config::Field&) {
    json[name] = value;
  }
};

Json json_of(OptimizerSettings settings) {
  SettingsWriter writer;
  settings.visit(writer);
  return writer.json;
}

/// A map as text, an entry a line.
std::string lines(const Json& map, const std::string& indent) {
  std::string text = "{\n";
  for (auto entry = map.begin(); entry != map.end(); ++entry) {
    if (entry != map.begin()) text += ",\n";
    text.append(indent).append("  ").append(Json(entry.key()).dump()).append(": ");
    const bool nested = entry->is_object();
    text += nested ? lines(*entry, indent + "  ") : entry->dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return text + "\n" + indent + "}";
}

std::string digest_of(Json content) {
  content.erase("digest");
  return hex(Hasher().add(content.dump(-1, ' ', false, Json::error_handler_t::replace)).value());
}

Error data(const std::string& message) { return {Code::data, "not a checkpoint that can be used: " + message}; }

/// The text as JSON whose digest is right.
Result<Json> parse(const std::string& text) {
  if (text.size() > kLargestText) return data("it is larger than 256 MB");
  bool too_deep = false;
  const auto watch = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kDeepest;
    return depth <= kDeepest;
  };
  Json content = Json::parse(text, watch, false);
  if (content.is_discarded() || !content.is_object()) return data("it is no JSON object; is it half a file?");
  if (too_deep) return data("it is nested deeper than a checkpoint");
  const auto format = content.find("format");
  if (format == content.end() || *format != kFormat) return data(std::string("'format' is not \"") + kFormat + "\"");
  const auto digest = content.find("digest");
  if (digest == content.end() || *digest != digest_of(content)) {
    return data("its digest does not match; it was damaged or changed by hand");
  }
  return content;
}

std::string short_text(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= 80 ? text : text.substr(0, 77) + "...";
}

/// Refuses a checkpoint that belongs to something else. `mine` is what it should hold beside its state.
Status check_same(const Json& content, const Json& mine) {
  for (const auto& [key, value] : mine.items()) {
    const auto at = content.find(key);
    if (at == content.end()) return data("'" + key + "' is missing");
    if (value.is_object() && at->is_object()) {
      PRIMO_TRY(check_same(*at, value));
    } else if (key != "evaluations" && *at != value) {
      return Error{Code::config, "the checkpoint is of another problem: its '" + key + "' is " + short_text(*at) +
                                     ", here it is " + short_text(value)};
    }
  }
  return success();
}

Json identity(const OptimizerSettings& settings, const Bounds& bounds, const std::string& problem) {
  return {{"format", kFormat},
          {"problem", problem},
          {"settings", json_of(settings)},
          {"lower", bounds.lower},
          {"upper", bounds.upper}};
}

Result<State> state_of(const Json& content) {
  const auto at = content.find("state");
  if (at == content.end() || !at->is_object()) return data("'state' is missing");
  State state;
  for (const auto& [name, values] : at->items()) {
    if (!values.is_array()) return data("'state." + name + "' is no list");
    auto& numbers = state[name];
    for (const auto& value : values) {
      if (!value.is_number()) return data("'state." + name + "' holds what is no number");
      numbers.push_back(value.get<double>());
    }
  }
  return state;
}

Result<std::unique_ptr<Optimizer>> restored(const Json& content, const OptimizerSettings& settings,
                                            const Bounds& bounds, const std::string& problem) {
  PRIMO_TRY(check_same(content, identity(settings, bounds, problem)));
  PRIMO_ASSIGN(const State state, state_of(content));
  PRIMO_ASSIGN(auto optimizer, make_optimizer(settings, bounds));
  PRIMO_TRY(optimizer->restore(state));
  return optimizer;
}

}  // namespace

std::string checkpoint_text(const Optimizer& optimizer, const std::string& problem) {
  Json content = identity(optimizer.settings(), optimizer.bounds(), problem);
  content["state"] = optimizer.state();
  // What is not valid UTF-8 in a name would not be found again; parse() sees the same replacement.
  content["digest"] = digest_of(content);
  return lines(content, "") + "\n";
}

Result<std::unique_ptr<Optimizer>> optimizer_from_text(const std::string& text, const OptimizerSettings& settings,
                                                       const Bounds& bounds, const std::string& problem) {
  PRIMO_ASSIGN(const Json content, parse(text));
  return restored(content, settings, bounds, problem);
}

Status save_checkpoint(const fs::path& file, const Optimizer& optimizer, const std::string& problem) {
  std::error_code ignored;
  if (fs::exists(file, ignored)) {
    const auto there = load_checkpoint(file, optimizer.settings(), optimizer.bounds(), problem);
    if (!there.ok()) return there.error();
    if ((*there)->evaluations() > optimizer.evaluations()) {
      return Error{Code::config, file.string() + ": the checkpoint there is further ahead (" +
                                     std::to_string((*there)->evaluations()) + " evaluations) than this search (" +
                                     std::to_string(optimizer.evaluations()) + "); does another process use it?"};
    }
  }
  return write_file(file, checkpoint_text(optimizer, problem));
}

Result<std::unique_ptr<Optimizer>> load_checkpoint(const fs::path& file, const OptimizerSettings& settings,
                                                   const Bounds& bounds, const std::string& problem) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return make_optimizer(settings, bounds);
  PRIMO_ASSIGN(const std::string text, read_file(file));
  auto optimizer = optimizer_from_text(text, settings, bounds, problem);
  if (!optimizer.ok()) return optimizer.error().at(file.string());
  return optimizer;
}

}  // namespace primo::optim

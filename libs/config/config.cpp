#include "config/config.h"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace primo::config {
namespace detail {

void refuse(const std::string& where, const YAML::Node& node, const std::string& message) {
  std::string place = where;
  if (node.IsDefined() && node.Mark().line >= 0) place += ":" + std::to_string(node.Mark().line + 1);
  throw Refused{{Code::config, place + ": " + message}};
}

std::string format(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

double number(const YAML::Node& node, const std::string& where, const std::string& key, const Field& field) {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || std::isnan(value)) {
    refuse(where, node, "'" + key + "' must be a number" + (node.IsScalar() ? ", not '" + node.Scalar() + "'" : ""));
  }
  if (value < field.min || value > field.max) {
    std::string bounds = std::isinf(field.max)   ? "at least " + format(field.min)
                         : std::isinf(field.min) ? "at most " + format(field.max)
                                                 : "between " + format(field.min) + " and " + format(field.max);
    refuse(where, node,
           "'" + key + "' is " + node.Scalar() + ", must be " + bounds + (field.unit.empty() ? "" : " " + field.unit));
  }
  return value;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string closest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = word.size() / 2 + 1;
  for (const auto& candidate : known) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 1; i <= word.size(); ++i) {  // Levenshtein distance, one row at a time
      std::size_t diagonal = std::exchange(row[0], i);
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i - 1] != candidate[j - 1]);
        diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, substituted}));
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

void Reader::refuse_unknown() const {
  if (!node_.IsMap()) return;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    const std::string guess = closest(key, known_);
    refuse(where_, entry.first,
           "unknown key '" + (prefix_.empty() ? key : prefix_ + "." + key) + "'" +
               (guess.empty() ? "; known keys: " + joined(known_) : "; did you mean '" + guess + "'?"));
  }
}

void Describer::line(const std::string& key, const std::string& value, const Field& field) const {
  text += "  " + key + ": " + (value.empty() ? "~" : value);
  if (!field.unit.empty()) text += " " + field.unit;
  if (!std::isinf(field.min) || !std::isinf(field.max))
    text += "  [" + format(field.min) + ", " + format(field.max) + "]";
  if (!field.choices.empty()) text += "  {" + joined(field.choices) + "}";
  if (!field.help.empty()) text += "  " + field.help;
  text += "\n";
}

Result<YAML::Node> parse(const std::string& text, const std::string& where) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    return Error{Code::config, where + ":" + std::to_string(e.mark.line + 1) + ": not valid YAML: " + e.msg};
  }
}

}  // namespace detail

Result<YAML::Node> override_keys(YAML::Node node, const std::vector<std::string>& assignments) {
  for (const auto& assignment : assignments) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Error{Code::usage, "override '" + assignment + "': expected key=value, e.g. optimizer.evaluations=500"};
    }
    PRIMO_ASSIGN(const YAML::Node value, detail::parse(assignment.substr(equals + 1), "override '" + assignment + "'"));
    YAML::Node at;
    at.reset(node);
    std::string path = assignment.substr(0, equals);
    for (std::size_t dot = 0; (dot = path.find('.')) != std::string::npos; path.erase(0, dot + 1)) {
      YAML::Node next = at[path.substr(0, dot)];
      if (next.IsDefined() && !next.IsMap() && !next.IsNull()) {
        return Error{Code::usage, "override '" + assignment + "': '" + path.substr(0, dot) + "' is not a map"};
      }
      at.reset(next);
    }
    at[path] = value;
  }
  return node;
}

}  // namespace primo::config

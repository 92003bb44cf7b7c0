// Experiences in small integers, by action: what the learner learns from. Takes some hundred bytes an experience.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "rules/grounding.h"
#include "symbols/derived.h"
#include "symbols/signatures.h"

namespace primo::rules {

/// What the learner is told beside the experiences.
struct Background {
  std::vector<symbols::Definition> derived;  ///< predicates and functions that contexts may use
  std::vector<std::string> constants;        ///< objects that are the same in all experiences, and that rules may name
};

class ExperienceStore {
 public:
  explicit ExperienceStore(Background background = {}) : background_(std::move(background)) {}

  /// Adds one. Experiences with the same non-empty id count once: true when this one is new. Errors (data), beginning
  /// with `where`: it is ill-formed, contradicts earlier ones in a predicate's arity, its id stands with other
  /// contents, it has more than 1000 objects, or a derived predicate occurs in it.
  Result<bool> add(const symbols::Experience& experience, const std::string& where);

  /// Brings the predicates in the order of their names, so that nothing depends on the order of the experiences. True
  /// when that changed scenes that were there before, or which predicates change.
  bool sort();

  const Background& background() const { return background_; }
  const Vocabulary& vocabulary() const { return vocabulary_; }
  /// By action. The vectors stay where they are; scenes are only added, and changed by sort() only.
  const std::map<std::string, std::vector<Scene>>& scenes() const { return scenes_; }
  /// The predicates (and functions) that some action changed, by number.
  const std::set<std::int16_t>& changing() const { return changing_; }
  std::int64_t size() const { return size_; }

 private:
  Status check(const symbols::Experience& experience) const;

  Background background_;
  symbols::Signatures signatures_;
  Vocabulary vocabulary_;
  std::size_t sorted_ = 0;  // predicates
  std::set<std::int16_t> changing_;
  std::size_t changing_then_ = 0;               // when they were sorted
  std::map<std::string, std::uint64_t> known_;  // id → contents
  std::map<std::string, std::vector<Scene>> scenes_;
  std::int64_t size_ = 0;
};

}  // namespace primo::rules

// What a study found. result.json holds it; it says nothing of times, hosts or order, so that an undisturbed run and
// one that was killed many times write the same bytes.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study/backend.h"

namespace primo::study {

/// Rates of one primitive on one set of rollouts.
struct Rates {
  Rate final_pose;                      ///< the final pose passes the jiggle, as in the paper
  Rate strict;                          ///< and the path is clean
  Rate desired;                         ///< strict, and the rule's desired outcome holds
  double gamma = 0;                     ///< mean fitness
  std::map<std::string, int> outcomes;  ///< how many ended in each physics::Outcome
  /// Of places: how many are on their support by "both" criteria, "full only", "paper only" or "neither".
  std::map<std::string, int> on;
};

/// What was seen of one primitive.
struct Collection {
  motion::Primitive primitive;
  Rates training;           ///< on the training scenarios, with the validation's seeds
  Rates displaced;          ///< on the displaced scenarios
  Rate executed;            ///< whole motions in full physics, on the first displaced scenarios
  Rate executed_of_strict;  ///< the same, of the plans that the strict verdict had accepted
  rules::RuleSet rules;     ///< learned from the displaced scenarios
  /// What held in every experience that the action's rule covers without being in its context: the data do not say
  /// whether it matters.
  std::vector<symbols::Literal> untested_context;
};

struct Optimization {
  std::vector<symbols::Literal> desired;  ///< over X, Y, …
  double gamma = 0;
  Rate success;
  int evaluations = 0;
};

/// A typical failure: a scenario of a level, by its index.
struct Example {
  int count = 0;     ///< failures of this cause
  int scenario = 0;  ///< the one whose motion ends in the middle of them, by its distance from the target
};

/// One primitive on the held-out scenarios of a level.
struct LevelRates {
  Rate final_pose, strict, executed;
  Rate executed_of_strict;                       ///< executed, of those that the strict verdict had accepted
  std::map<std::string, Example> failures;       ///< of the strict verdict, by cause
  std::map<std::string, Example> not_executed;   ///< of the execution, by cause
  std::optional<rules::RuleSet> rules;           ///< learned at this level from final poses
  std::optional<rules::RuleSet> executed_rules;  ///< and from executed motions
};

/// P and P* on the same held-out scenarios.
struct Level {
  double displacement = 0;  ///< m
  int rejected_touching = 0, rejected_falling = 0,
      rejected_in_robot = 0;  ///< draws that were refused for the scenarios kept
  LevelRates before, after;
  Paired final_pose, strict, executed;  ///< first: P, second: P*
};

struct PartResult {
  std::string name;
  std::string action;
  std::vector<Collection> collections;      ///< with P, P*, P**, …: one more than rounds
  std::vector<Optimization> optimizations;  ///< one a round
  std::string end;                          ///< why the loop ended
  std::vector<Level> levels;                ///< by rising displacement
};

struct StudyResult {
  std::string study;
  std::vector<PartResult> parts;
};

std::string to_json(const StudyResult& result);
Result<StudyResult> result_from_json(const std::string& text);

/// Reads result.json of a study's directory.
Result<StudyResult> read_result(const std::filesystem::path& directory);

/// The rule of this action whose outcomes hold the desired literals (by action variables X, Y, …), or the first of the
/// action, or nullptr.
const rules::Rule* rule_of(const rules::RuleSet& rules, const std::string& action);

/// Whether the rules differ: another structure (contexts, outcomes), or a probability outside the other's 95 %
/// interval.
bool rules_changed(const rules::RuleSet& before, const rules::RuleSet& after);

/// A rule in the form of the paper's tables: the outcome that holds all of `desired` (over X, Y, …) against noise.
/// Where none does, the most probable outcome that changes anything.
rules::Rule desired_rule(const rules::Rule& rule, const std::vector<symbols::Literal>& desired);

/// desired_rule() of the action's rule in a set, for the outcome that the part's first optimization was for; none where
/// the set has no rule of the action.
std::optional<rules::Rule> shown_rule(const PartResult& part, const rules::RuleSet& rules);

/// The literals of a rule with its variables renamed: the action's arguments to X, Y, …, deictic ones to what follows.
std::vector<symbols::Literal> canonical(const std::vector<symbols::Literal>& literals, const symbols::Literal& action);

/// An open entry of one primitive, of another, or of both: its name and value in each.
struct EntryPair {
  std::string name;
  std::optional<motion::OpenEntry> before, after;
};
/// Entries of both by name, those of `before` first.
std::vector<EntryPair> paired_entries(const motion::Primitive& before, const motion::Primitive& after);

/// For a terminal, of each part: the action's rule before and after in the paper's notation, each outcome with its
/// count and 95 % interval, the rates three ways, ρ before and after.
std::string summary(const StudyResult& result);

}  // namespace primo::study

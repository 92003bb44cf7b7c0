// The study's loop (paper, IV.C): collect experience with P, learn rules, optimize P against the rules' desired
// outcome, collect again, learn again, until the rules no longer change.
#pragma once

#include <filesystem>

#include "study/backend.h"
#include "study/optimization.h"
#include "study/result.h"
#include "study/study.h"

namespace primo::study {

/// Runs the study in its directory, going on from where its journal ends. Writes experience-<collection>.jsonl and,
/// last, result.json. Errors: a journal that cannot be used, workers that cannot do their part, no experience in which
/// the action changes anything.
Result<StudyResult> run_study(const Study& study, const std::filesystem::path& directory, Workers& workers,
                              const OnProgress& on_progress = {});

/// Runs a goal with the journal of its directory: what an optimizer process does with a goal it receives.
Result<OptimizeResult> optimize_in_directory(const OptimizeGoal& goal, Evaluator& evaluator,
                                             const OnProgress& on_progress = {});

}  // namespace primo::study

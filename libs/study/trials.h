// What a study asks of its workers, by way of its journal: scenes observed, rollouts evaluated, rules learned.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "study/backend.h"
#include "study/journal.h"
#include "study/optimization.h"

namespace primo::study {

/// Rollouts and, once evaluated, what came of them, in the same order.
struct Tries {
  std::vector<Rollout> rollouts;
  std::vector<RolloutResult> results;
};

class Trials {
 public:
  /// All are kept by reference. `heading`: the study and part that progress is of.
  Trials(Workers& workers, Journal& journal, const OnProgress& on_progress, Progress heading)
      : workers_(workers),
        journal_(journal),
        evaluator_(workers, journal),
        on_progress_(on_progress),
        heading_(std::move(heading)) {}

  void set_round(int round) { heading_.round = round; }
  int round() const { return heading_.round; }

  void progress(const std::string& stage, int done, int total, const Rate& success = {}, bool finished = false,
                const std::string& text = "") const;

  /// Runs and times a stage. @pre work returns a Status.
  template <class F>
  Status stage(const std::string& name, F&& work);

  /// Estimates of the scenes, in order.
  Result<std::vector<scene::SceneEstimate>> observe(const std::vector<scene::Scenario>& scenarios);

  /// Fills in the results. Error: a request that the planner refuses, workers that cannot do their part.
  Status evaluate(Tries& tries, const std::string& stage_name);

  /// Rules of these experiences; `batch` names them (a digest is added to it).
  Result<rules::RuleSet> learn(const std::string& batch, const std::vector<symbols::Experience>& experiences);

  Result<OptimizeResult> optimize(const OptimizeGoal& goal);

 private:
  using Clock = std::chrono::steady_clock;
  Workers& workers_;
  Journal& journal_;
  JournaledEvaluator evaluator_;
  const OnProgress& on_progress_;
  Progress heading_;
};

template <class F>
Status Trials::stage(const std::string& name, F&& work) {
  const auto begin = Clock::now();
  const auto asked = evaluator_.asked();
  PRIMO_TRY(work());
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return journal_.record_timing({heading_.part, heading_.round, name, seconds, evaluator_.asked() - asked});
}

/// The experience of a judged rollout: the symbols before, the action, the symbols after.
symbols::Experience experience_of(const std::string& id, const Rollout& rollout, const RolloutResult& result);

}  // namespace primo::study

#include <algorithm>
#include <map>

#include "study/curves.h"

namespace primo::study {
namespace {

/// Evaluations until some candidate succeeded in at least so many scenarios; 0: none did.
int evaluations_until(const std::vector<EvaluationRecord>& restart, int successes) {
  for (std::size_t i = 0; i < restart.size(); ++i) {
    if (restart[i].scenarios > 0 && restart[i].successes >= successes) return static_cast<int>(i) + 1;
  }
  return 0;
}

struct Restart {
  std::vector<EvaluationRecord> course;
  const FinalistRecord* recommended = nullptr;  // the better one, by γ with fresh seeds
};

}  // namespace

std::vector<SearchSummary> summarize_searches(const std::vector<EvaluationRecord>& evaluations,
                                              const std::vector<FinalistRecord>& finalists) {
  std::map<std::string, std::map<int, Restart>> searches;
  for (const auto& record : evaluations) {
    if (record.round == 0) searches[record.algorithm][record.restart].course.push_back(record);
  }
  for (const auto& record : finalists) {
    const auto search = searches.find(record.algorithm);
    if (record.round != 0 || search == searches.end() || !search->second.contains(record.restart)) continue;
    auto& best = search->second[record.restart].recommended;
    if (best == nullptr || record.gamma > best->gamma) best = &record;
  }
  std::vector<SearchSummary> summaries;
  for (const auto& [algorithm, restarts] : searches) {
    SearchSummary summary;
    summary.algorithm = algorithm;
    for (const auto& [number, restart] : restarts) {  // a candidate that was dropped met fewer scenarios
      for (const auto& e : restart.course) summary.scenarios = std::max(summary.scenarios, e.scenarios);
    }
    for (const auto& [number, restart] : restarts) {
      ++summary.restarts;
      const int all = evaluations_until(restart.course, summary.scenarios);
      const int but_one = evaluations_until(restart.course, summary.scenarios - 1);
      summary.everywhere.add(all > 0);
      summary.all_but_one_restarts.add(but_one > 0);
      summary.evaluations_mean += all;
      summary.evaluations_worst = std::max<double>(summary.evaluations_worst, all);
      summary.all_but_one_mean += but_one;
      if (restart.recommended == nullptr) continue;
      const Rate& rate = restart.recommended->success;
      summary.recommended_everywhere.add(rate.successes == rate.trials);
      summary.recommended.successes += rate.successes;
      summary.recommended.trials += rate.trials;
    }
    summary.evaluations_mean /= std::max<double>(1, static_cast<double>(summary.everywhere.successes));
    summary.all_but_one_mean /= std::max<double>(1, static_cast<double>(summary.all_but_one_restarts.successes));
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

}  // namespace primo::study

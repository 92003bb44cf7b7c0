#include "study/candidates.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "study/fitness.h"

namespace primo::study {
namespace {

/// Means of the sums, as they stand.
std::vector<Score> means(std::vector<Score> scores) {
  for (auto& score : scores) {
    score.gamma /= std::max(1, score.rollouts);
    score.rank = score.gamma;
  }
  return scores;
}

/// The `count` best of `racers` by mean γ, and all that equal the last of these.
std::vector<std::size_t> best_of(std::vector<std::size_t> racers, std::size_t count, const std::vector<Score>& sums) {
  const auto mean = [&](std::size_t p) { return sums[p].gamma / std::max(1, sums[p].rollouts); };
  std::vector<double> sorted;
  for (const std::size_t p : racers) sorted.push_back(mean(p));
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  const double last = sorted[std::min(count, sorted.size()) - 1];
  std::erase_if(racers, [&](std::size_t p) { return mean(p) < last; });
  return racers;
}

/// Ranks what was dropped in a round, best first as it was dropped, below everything in `above`.
void rank_below(const std::vector<std::size_t>& dropped, const std::vector<std::size_t>& above,
                std::vector<Score>& scores) {
  if (dropped.empty()) return;
  double floor = scores[above.front()].rank, top = scores[dropped.front()].gamma;
  for (const std::size_t p : above) floor = std::min(floor, scores[p].rank);
  for (const std::size_t p : dropped) top = std::max(top, scores[p].gamma);
  for (const std::size_t p : dropped) {
    scores[p].rank = std::nextafter(floor, -1e300) - (top - scores[p].gamma);
    scores[p].whole = false;
  }
}

}  // namespace

Status Candidates::add(const std::vector<motion::Primitive>& primitives, const std::vector<Trial>& trials,
                       std::vector<Score>& sums) {
  std::vector<Rollout> rollouts;
  rollouts.reserve(trials.size());
  for (const auto& trial : trials) {
    rollouts.push_back({goal_.scenarios[trial.scenario], goal_.estimates[trial.scenario], primitives[trial.primitive],
                        trial.seed, physics::Mode::final_pose, goal_.judge});
  }
  std::vector<double> g(trials.size(), std::nan(""));
  std::string refused;
  PRIMO_TRY(evaluator_.evaluate(rollouts, [&](std::size_t i, const RolloutResult& result) {
    const auto& scenario = goal_.scenarios[trials[i].scenario];
    if (result.plan_status == motion::PlanStatus::bad_input) refused = scenario.name + ": " + result.plan_reason;
    const bool success = succeeded(result, goal_.desired, scenario.action);
    g[i] = signal(result, success, settings_.signal, settings_.fitness);
    Score& sum = sums[trials[i].primitive];
    sum.successes += success;
    sum.final_pose += result.verdict.final_pose_success;
    ++sum.rollouts;
  }));
  if (!refused.empty()) return Error{Code::failed, "the planner refused a request of the optimization: " + refused};
  // Summed in the order of the trials: that of the answers must not matter, to the last bit.
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (!std::isfinite(g[i])) {
      return Error{Code::failed, "no fitness of candidate " + std::to_string(trials[i].primitive) + " in scenario " +
                                     goal_.scenarios[trials[i].scenario].name + ": its rollout was not answered"};
    }
    sums[trials[i].primitive].gamma += g[i];
  }
  rollouts_ += static_cast<std::int64_t>(trials.size());
  return success();
}

Result<std::vector<Score>> Candidates::evaluate(const std::vector<motion::Primitive>& primitives,
                                                const std::vector<std::size_t>& scenarios,
                                                const std::vector<SeedOf>& seeds) {
  std::vector<Trial> trials;
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    for (const auto& seed : seeds) {
      for (const std::size_t k : scenarios) trials.push_back({p, k, seed(p, k)});
    }
  }
  std::vector<Score> sums(primitives.size());
  PRIMO_TRY(add(primitives, trials, sums));
  return means(std::move(sums));
}

Result<std::vector<Score>> Candidates::contest(const std::vector<motion::Primitive>& primitives,
                                               const std::vector<std::size_t>& scenarios, const SeedOf& seed,
                                               double to_beat) {
  const double most = best_signal(settings_.signal, settings_.fitness), all = static_cast<double>(scenarios.size());
  std::vector<Score> sums(primitives.size());
  std::vector<std::size_t> open(primitives.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  for (std::size_t k = 0; k < scenarios.size() && !open.empty(); ++k) {
    std::vector<Trial> trials;
    for (const std::size_t p : open) trials.push_back({p, scenarios[k], seed(p, scenarios[k])});
    PRIMO_TRY(add(primitives, trials, sums));
    const double left = all - static_cast<double>(k + 1);
    std::erase_if(open, [&](std::size_t p) {
      const bool lost = left > 0 && sums[p].gamma + left * most < to_beat * all;
      if (lost) sums[p].whole = false;
      return lost;
    });
  }
  return means(std::move(sums));
}

Result<std::vector<Score>> Candidates::race(const std::vector<motion::Primitive>& primitives,
                                            const std::vector<std::size_t>& scenarios, const SeedOf& seed,
                                            std::size_t first, std::size_t sure) {
  if (settings_.racing.rounds.empty()) return evaluate(primitives, scenarios, {seed});
  const std::size_t all = scenarios.size();
  std::vector<Score> sums(primitives.size());
  std::vector<std::size_t> racers(primitives.size());
  std::iota(racers.begin(), racers.end(), std::size_t{0});
  std::vector<std::vector<std::size_t>> dropped;  // in each round
  std::vector<std::size_t> rounds;
  for (const int round : settings_.racing.rounds) rounds.push_back(std::min(all, static_cast<std::size_t>(round)));
  rounds.push_back(all);

  std::size_t done = 0;
  for (const std::size_t until : rounds) {
    std::vector<Trial> trials;
    for (const std::size_t p : racers) {
      for (std::size_t k = done; k < until; ++k) {
        const std::size_t scenario = scenarios[(first + k) % all];
        trials.push_back({p, scenario, seed(p, scenario)});
      }
    }
    PRIMO_TRY(add(primitives, trials, sums));
    done = std::max(done, until);
    if (done == all) break;
    const auto share = static_cast<std::size_t>(std::ceil(settings_.racing.keep * static_cast<double>(racers.size())));
    auto kept = best_of(racers, std::max<std::size_t>(1, share), sums);
    std::vector<std::size_t> losers;
    for (const std::size_t p : racers) {
      if (std::find(kept.begin(), kept.end(), p) != kept.end()) continue;
      (p < sure ? kept : losers).push_back(p);
    }
    std::sort(kept.begin(), kept.end());
    racers = std::move(kept);
    dropped.push_back(std::move(losers));
  }
  auto scores = means(std::move(sums));
  std::vector<std::size_t> above = racers;
  for (auto round = dropped.rbegin(); round != dropped.rend(); ++round) {
    rank_below(*round, above, scores);
    above.insert(above.end(), round->begin(), round->end());
  }
  return scores;
}

}  // namespace primo::study

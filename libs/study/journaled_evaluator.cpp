#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "study/codec.h"
#include "study/journal.h"

namespace primo::study {
namespace {

using Clock = std::chrono::steady_clock;

/// A transaction costs a sync of the disk; answers that arrive within this time share one. It delays answers, and
/// changes none.
constexpr auto kFlushAfter = std::chrono::milliseconds(250);
constexpr std::size_t kFlushCount = 64;

}  // namespace

Status JournaledEvaluator::evaluate(std::span<const Rollout> rollouts,
                                    const std::function<void(std::size_t index, RolloutResult result)>& on_result) {
  std::vector<std::string> keys(rollouts.size());
  std::vector<std::size_t> missing;                          // indices to ask for, each key once
  std::map<std::string, std::vector<std::size_t>> asked_by;  // all indices that wait for a key
  for (std::size_t i = 0; i < rollouts.size(); ++i) {
    keys[i] = key_of(rollouts[i]);
    PRIMO_ASSIGN(const auto reply, journal_.find(keys[i]));
    if (reply) {
      PRIMO_ASSIGN(auto result, decode_rollout_result(*reply));
      ++recalled_;
      on_result(i, std::move(result));
    } else {
      auto& indices = asked_by[keys[i]];
      if (indices.empty()) missing.push_back(i);
      indices.push_back(i);
    }
  }
  if (missing.empty()) return success();

  std::vector<Rollout> questions;
  for (const std::size_t i : missing) questions.push_back(rollouts[i]);
  std::vector<Answer> arrived;
  std::vector<RolloutResult> results;  // of the arrived
  Status failure = success();
  auto last_flush = Clock::now();
  auto last_answer = last_flush;
  const auto flush = [&]() -> Status {
    if (arrived.empty()) return success();
    PRIMO_ASSIGN(const auto replies, journal_.record(arrived));
    for (std::size_t a = 0; a < arrived.size(); ++a) {
      // What was recorded is what counts, so that a later run that reads it goes the same way: mostly what arrived.
      if (replies[a] != arrived[a].reply) {
        PRIMO_ASSIGN(results[a], decode_rollout_result(replies[a]));
      }
      for (const std::size_t i : asked_by[arrived[a].key]) on_result(i, results[a]);
    }
    arrived.clear();
    results.clear();
    last_flush = Clock::now();
    return success();
  };
  const Status asked = inner_.evaluate(questions, [&](std::size_t q, RolloutResult result) {
    if (!failure.ok()) return;
    ++asked_;
    const auto now = Clock::now();
    arrived.push_back(
        {keys[missing[q]], "rollout", encode(result), std::chrono::duration<double>(now - last_answer).count()});
    results.push_back(std::move(result));
    last_answer = now;
    if (arrived.size() >= kFlushCount || now - last_flush >= kFlushAfter) failure = flush();
  });
  if (failure.ok()) failure = flush();  // what came is kept, also when the rest did not
  PRIMO_TRY(failure);
  return asked;
}

}  // namespace primo::study

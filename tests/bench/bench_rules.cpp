// How long learning takes and how far the learned rules are from those that made the data: total variation distance on
// held-out (state, action), mean over seeds.
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "rules/learner.h"
#include "unit/rules/generated_data.h"

namespace {

using namespace primo::rules;
using Draw = std::vector<primo::symbols::Experience> (*)(const RuleSet&, int, std::uint64_t);

nlohmann::ordered_json measure(const char* name, const RuleSet& truth, Draw draw, int n) {
  constexpr int kSeeds = 5;
  const auto test = draw(truth, 500, 1000);
  double seconds = 0, distance = 0, gain = 0, rules = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto data = draw(truth, n, seed);
    const auto begin = std::chrono::steady_clock::now();
    const auto learned = learn(data).value();
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / kSeeds;
    distance += generated::variational_distance(truth, learned, test) / kSeeds;
    gain += (score(learned, data) - score(truth, data)) / kSeeds;
    rules += static_cast<double>(learned.rules.size()) / kSeeds;
  }
  return {{"domain", name},       {"experiences", n},          {"seconds", seconds},
          {"distance", distance}, {"score_above_truth", gain}, {"rules", rules}};
}

}  // namespace

int main() {
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  for (const int n : {50, 100, 200, 500, 1000}) {
    results.push_back(measure("grasp_place", generated::grasp_place(0.94, 0.92), generated::grasp_place_data, n));
    results.push_back(measure("grasp_place_noise_free", generated::grasp_place(1, 1), generated::grasp_place_data, n));
    results.push_back(measure("slippery_gripper", generated::slippery_gripper(), generated::slippery_gripper_data, n));
  }
  std::printf("%s\n", nlohmann::ordered_json{{"bench", "rules"}, {"results", results}}.dump(1).c_str());
}

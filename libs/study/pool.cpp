#include "study/pool.h"

#include <map>
#include <numeric>

#include "core/check.h"
#include "core/random.h"
#include "scene/generator.h"

namespace primo::study {

Result<std::vector<scene::Scenario>> draw_pool(const robot::Robot& robot, const std::vector<scene::Scenario>& training,
                                               int count, double displacement, std::uint64_t seed,
                                               const std::string& label) {
  PRIMO_CHECK(!training.empty(), "a pool needs training scenarios");
  const auto total = static_cast<std::size_t>(count), originals = training.size();
  std::vector<scene::Scenario> pool;
  for (std::size_t original = 0; original < originals; ++original) {
    const std::size_t copies = total / originals + (original < total % originals ? 1 : 0);
    for (std::size_t j = 0; j < copies; ++j) {
      const auto index = static_cast<std::uint64_t>(pool.size());
      const double share =
          (static_cast<double>(j) + Random(seed, "pool", {index}).uniform()) / static_cast<double>(copies);
      PRIMO_ASSIGN(auto copy, scene::displace(robot, training[original], share * displacement, seed, index));
      copy.scenario.name = training[original].name + "_" + label + "_" + std::to_string(index);
      pool.push_back(std::move(copy.scenario));
    }
  }
  return pool;
}

std::vector<std::size_t> draw_from_pool(std::size_t pool, std::size_t drawn, std::uint64_t seed, int round,
                                        int generation) {
  std::vector<std::size_t> chosen;
  if (drawn == 0 || drawn >= pool) {
    chosen.resize(pool);
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
    return chosen;
  }
  Random random(seed, "pool of a generation",
                {static_cast<std::uint64_t>(round), static_cast<std::uint64_t>(generation)});
  for (std::size_t part = 0; part < drawn; ++part) {
    const std::size_t begin = part * pool / drawn, end = (part + 1) * pool / drawn;
    chosen.push_back(begin + random.below(end - begin));
  }
  return chosen;
}

Status check_distinct_seeds(const std::vector<std::pair<std::string, std::uint64_t>>& seeds) {
  std::map<std::uint64_t, std::string> taken;
  for (const auto& [key, seed] : seeds) {
    const auto [at, fresh] = taken.emplace(seed, key);
    if (fresh) continue;
    return Error{Code::config, "'" + key + "' is " + std::to_string(seed) + ", the same as '" + at->second +
                                   "'; training, choice, experience and tests must come from different random numbers"};
  }
  return success();
}

}  // namespace primo::study

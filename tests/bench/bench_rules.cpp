// What learning costs and how far the learned rules are from those that made the data, on the domains of
// rule_domains.h: total variation distance on held-out (state, action), mean over seeds; score against the true rules'
// on every training file; CPU time, with distractors, one experience more, and memory at 100 000 experiences.
//
//   bench_rules [--json] [--seeds 5] [--first-seed 1] [--development] [--large]
//
// Choices in the learner are made on --development files only: 40 a point, from seeds of their own.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/measure.h"
#include "bench/rule_domains.h"
#include "rules/online.h"
#include "rules/parameters.h"
#include "rules/score.h"

namespace {

namespace bench = primo::bench;
using namespace primo::rules;
using Json = nlohmann::ordered_json;
using primo::symbols::Experience;

/// The true structure with the probabilities most likely on the data: what no learner can be expected to beat.
RuleSet fitted_truth(const RuleSet& truth, const std::vector<Experience>& data) {
  RuleSet fitted = truth;
  const Predictor predictor(truth);
  std::vector<std::map<std::vector<int>, double>> cells(truth.rules.size());
  for (const auto& e : data) {
    Binding binding;
    const Rule* rule = predictor.covering(e.objects, e.before, e.action, &binding);
    if (!rule) continue;
    std::vector<int> explained;
    for (std::size_t o = 0; o < rule->outcomes.size(); ++o) {
      const auto after = apply_outcome(e.before, ground(rule->outcomes[o].literals, binding));
      if (after == e.after) explained.push_back(static_cast<int>(o));
    }
    ++cells[static_cast<std::size_t>(rule - truth.rules.data())][explained];
  }
  for (std::size_t r = 0; r < cells.size(); ++r) {
    if (cells[r].empty()) continue;
    std::vector<MixtureCell> list;
    for (const auto& [outcomes, weight] : cells[r]) list.push_back({outcomes, weight});
    auto& rule = fitted.rules[r];
    const auto fit = fit_outcomes(list, static_cast<int>(rule.outcomes.size()), LearnerSettings{}.p_min);
    for (std::size_t o = 0; o < rule.outcomes.size(); ++o) rule.outcomes[o].p = fit.p[o];
    rule.noise = fit.noise;
  }
  return fitted;
}

struct Seeds {
  std::uint64_t first = 1;
  int count = 5;
  std::uint64_t test = 1000;  ///< of the held-out states
};

constexpr Seeds kDevelopment{.first = 1001, .count = 40};

Json measure(const std::string& name, const domains::Domain& domain, int n, const Seeds& seeds, int distractors = 0) {
  auto test = domain.data(500, seeds.test, domains::Use::test);
  domains::add_distractors(test, distractors, seeds.test);
  double seconds = 0, distance = 0, reference = 0, rules = 0, worst = 1e300;
  int below = 0, exact = 0, certain = 0;
  for (int s = 0; s < seeds.count; ++s) {
    const std::uint64_t seed = seeds.first + static_cast<std::uint64_t>(s);
    auto data = domain.data(n, seed);
    domains::add_distractors(data, distractors, seed);
    const double begin = bench::cpu_seconds();
    const auto learned = learn(data).value();
    seconds += bench::cpu_seconds() - begin;
    const double d = generated::variational_distance(domain.truth, learned, test);
    distance += d;
    exact += d == 0;
    certain += assess(learned, data, LearnerSettings{}.p_min).log_likelihood > -1e-9;
    reference += generated::variational_distance(domain.truth, fitted_truth(domain.truth, data), test);
    const double above = score(learned, data) - score(domain.truth, data);
    worst = std::min(worst, above);
    below += above < -1e-9;
    rules += static_cast<double>(learned.rules.size());
  }
  const double k = seeds.count;
  return {{"domain", name},
          {"experiences", n},
          {"distractors", distractors},
          {"seeds", seeds.count},
          {"cpu_s", seconds / k},
          {"distance", distance / k},
          {"distance_of_true_structure", reference / k},
          {"exact", exact},
          {"certain_of_training", certain},
          {"least_score_above_truth", worst},
          {"files_below_truth", below},
          {"rules", rules / k}};
}

/// CPU time to add one experience to 1000 and to have the rules of all of them again.
Json one_more(const Seeds& seeds) {
  std::vector<double> quick, exact;
  double difference = 0;
  const auto domain = domains::gripper();
  for (int s = 0; s < seeds.count; ++s) {
    const auto data = domain.data(1100, seeds.first + static_cast<std::uint64_t>(s));
    const auto online = OnlineLearner::create().value();
    for (std::size_t i = 0; i < 1000; ++i) (void)online->note(data[i]);
    online->settle();
    for (std::size_t i = 1000; i < data.size(); ++i) {
      double begin = bench::cpu_seconds();
      (void)online->add(data[i]);
      quick.push_back(bench::cpu_seconds() - begin);
      begin = bench::cpu_seconds();
      online->settle();
      exact.push_back(bench::cpu_seconds() - begin);
    }
    difference = std::max(difference, score(learn(data).value(), data) - score(online->rules(), data));
  }
  return {{"what", "one experience more than 1000"},
          {"updates", exact.size()},
          {"add_median_s", bench::median(quick)},
          {"settle_median_s", bench::median(exact)},
          {"settle_most_s", *std::max_element(exact.begin(), exact.end())},
          {"most_score_below_batch", difference}};
}

Json large() {
  const auto domain = domains::gripper();
  ExperienceStore store;
  constexpr int kN = 100000;
  double begin = bench::cpu_seconds();
  for (int i = 0; i < kN; ++i) {
    primo::Random random(1, "large", {static_cast<std::uint64_t>(i)});
    auto e = domain.draw(random, domains::Use::training);
    generated::act(random, domain.truth, e);
    // As from a file: written and read.
    const auto read = primo::symbols::experience_from_json(to_json_line(e));
    (void)store.add(*read, "experience");
  }
  const double loaded = bench::cpu_seconds() - begin;
  const double loaded_mib = bench::peak_memory();
  begin = bench::cpu_seconds();
  const auto rules = learn(store, {}).value();
  return {{"what", "100000 experiences"},     {"load_cpu_s", loaded},
          {"load_peak_mib", loaded_mib},      {"learn_cpu_s", bench::cpu_seconds() - begin},
          {"peak_mib", bench::peak_memory()}, {"rules", rules.rules.size()}};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Benchmarks of the rule learner"};
  bool json = false, with_large = false, development = false;
  Seeds seeds;
  app.add_flag("--json", json, "one JSON object on one line; otherwise indented");
  app.add_option("--seeds", seeds.count, "training files a point")->capture_default_str();
  app.add_option("--first-seed", seeds.first, "seed of the first file")->capture_default_str();
  app.add_flag("--development", development, "files on which choices are made, in place of --seeds and --first-seed");
  app.add_flag("--large", with_large, "100 000 experiences too (a minute)");
  CLI11_PARSE(app, argc, argv);
  if (development) seeds = kDevelopment;
  Json results = Json::array();
  for (const int n : {50, 100, 200, 500, 1000}) {
    results.push_back(measure("grasp and place, noise-free", domains::grasp_place(1, 1), n, seeds));
    results.push_back(
        measure("grasp and place, noise-free, stacked evenly", domains::stacked_grasp_place(1, 1), n, seeds));
    results.push_back(measure("grasp and place .94 .92", domains::grasp_place(0.94, 0.92), n, seeds));
    results.push_back(measure("slippery gripper", domains::gripper(), n, seeds));
    results.push_back(measure("trucks and drivers", domains::trucks(), n, seeds));
    results.push_back(measure("coins", domains::coins(), n, seeds));
  }
  results.push_back(measure("slippery gripper", domains::gripper(), 200, seeds, 15));
  results.push_back(measure("slippery gripper", domains::gripper(), 1000, seeds, 15));
  results.push_back(one_more(seeds));
  if (with_large) results.push_back(large());
  const Json all = {{"bench", "rules"}, {"results", results}};
  std::printf("%s\n", all.dump(json ? -1 : 1).c_str());
}

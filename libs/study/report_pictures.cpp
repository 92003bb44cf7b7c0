#include "study/report_pictures.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/files.h"
#include "motion/planner.h"
#include "physics/picture.h"
#include "study/causes.h"
#include "study/codec.h"
#include "study/generalization.h"
#include "study/rollout.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

/// Causes of each primitive that are shown.
constexpr std::size_t kMostFailures = 4;

/// One primitive in one scenario.
struct Motion {
  Rollout rollout;
  motion::Plan plan;
  RolloutResult result;
};

class Artist {
 public:
  Artist(const Part& part, LocalWorkers& workers, Journal& journal, fs::path folder)
      : part_(part), workers_(workers), journal_(journal), folder_(std::move(folder)) {}

  Status draw_training(const motion::Primitive& before, const motion::Primitive& after, PartPictures& pictures);
  Status draw_failures(const std::vector<Level>& levels, const motion::Primitive& primitive, bool optimized,
                       PartPictures& pictures);

 private:
  Result<scene::SceneEstimate> estimate(const scene::Scenario& scenario);
  Result<Motion> motion(Rollout rollout);
  Result<Motion> in_training(const motion::Primitive& primitive, std::size_t k);
  Result<std::string> motion_picture(const Motion& motion, const std::string& name, bool dashed,
                                     const Motion* compare = nullptr) const;
  Result<std::string> hand_picture(const Motion& motion, const std::string& name) const;
  fs::path file(const std::string& name) const { return folder_ / (part_.name + "_" + name + ".png"); }

  const Part& part_;
  LocalWorkers& workers_;
  Journal& journal_;
  fs::path folder_;
};

/// As the study saw it: from its journal.
Result<scene::SceneEstimate> Artist::estimate(const scene::Scenario& scenario) {
  PRIMO_ASSIGN(const auto reply, journal_.find(key_of(scenario)));
  if (reply) return decode_estimate(*reply);
  return observe_scenario(scenario);
}

Result<Motion> Artist::motion(Rollout rollout) {
  Motion motion;
  motion.rollout = std::move(rollout);
  motion.plan = motion::plan(workers_.robot(), plan_request(motion.rollout));
  if (!has_trajectory(motion.plan)) {
    return Error{Code::failed, "no plan to draw in " + motion.rollout.scenario.name + ": " + motion.plan.reason};
  }
  PRIMO_ASSIGN(motion.result, workers_.judge(motion.rollout, motion.plan));
  return motion;
}

Result<Motion> Artist::in_training(const motion::Primitive& primitive, std::size_t k) {
  PRIMO_ASSIGN(auto seen, estimate(part_.training[k]));
  return motion({part_.training[k], std::move(seen), primitive, validation_seed(part_.settings.seed, 0, k),
                 physics::Mode::final_pose, part_.settings.judge});
}

Result<std::string> Artist::motion_picture(const Motion& motion, const std::string& name, bool dashed,
                                           const Motion* compare) const {
  physics::MotionPictureOptions options;
  options.dashed = dashed;
  if (compare != nullptr) options.compare = &compare->plan.trajectory.q;
  PRIMO_TRY(physics::render_motion_png(file(name), workers_.robot(), motion.rollout.scenario, motion.plan.trajectory.q,
                                       options));
  return read_file(file(name));
}

Result<std::string> Artist::hand_picture(const Motion& motion, const std::string& name) const {
  const Eigen::VectorXd q = motion.plan.trajectory.q.bottomRows(1).transpose();
  physics::PictureOptions options;
  options.view = physics::close_up(workers_.robot(), motion.rollout.scenario, q);
  options.close_hand = true;
  PRIMO_TRY(physics::render_png(file(name), &workers_.robot(), motion.rollout.scenario, q, options));
  return read_file(file(name));
}

Status Artist::draw_training(const motion::Primitive& before, const motion::Primitive& after, PartPictures& pictures) {
  const auto differ = [](const Motion& p, const Motion& q) {
    return !p.result.verdict.success && q.result.verdict.success;
  };
  PRIMO_ASSIGN(Motion old_motion, in_training(before, 0));
  PRIMO_ASSIGN(Motion new_motion, in_training(after, 0));
  for (std::size_t k = 1; k < part_.training.size() && !differ(old_motion, new_motion); ++k) {
    PRIMO_ASSIGN(Motion old_here, in_training(before, k));
    PRIMO_ASSIGN(Motion new_here, in_training(after, k));
    if (!differ(old_here, new_here)) continue;
    old_motion = std::move(old_here);
    new_motion = std::move(new_here);
  }
  const scene::Scenario& scenario = old_motion.rollout.scenario;
  pictures.scenario = scenario.name;
  pictures.verdict_before = old_motion.result.verdict.reason;
  pictures.verdict_after = new_motion.result.verdict.reason;
  PRIMO_TRY(
      physics::render_png(file("scene"), &workers_.robot(), scenario, old_motion.plan.trajectory.q.row(0).transpose()));
  PRIMO_ASSIGN(pictures.scene, read_file(file("scene")));
  PRIMO_ASSIGN(pictures.motion_before, motion_picture(old_motion, "motion_before", true));
  PRIMO_ASSIGN(pictures.motion_after, motion_picture(new_motion, "motion_after", false));
  PRIMO_ASSIGN(pictures.motion_both, motion_picture(new_motion, "motion_both", false, &old_motion));
  PRIMO_ASSIGN(pictures.hand_before, hand_picture(old_motion, "hand_before"));
  PRIMO_ASSIGN(pictures.hand_after, hand_picture(new_motion, "hand_after"));
  return success();
}

Status Artist::draw_failures(const std::vector<Level>& levels, const motion::Primitive& primitive, bool optimized,
                             PartPictures& pictures) {
  // Each cause where it is most frequent.
  std::map<std::string, std::size_t> worst;
  const auto failures = [&](std::size_t level) -> const auto& {
    return (optimized ? levels[level].after : levels[level].before).failures;
  };
  for (std::size_t level = 0; level < levels.size(); ++level) {
    for (const auto& [cause, example] : failures(level)) {
      const auto at = worst.emplace(cause, level).first;
      if (example.count > failures(at->second).at(cause).count) at->second = level;
    }
  }
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [cause, level] : worst) order.emplace_back(-failures(level).at(cause).count, cause);
  std::sort(order.begin(), order.end());
  if (order.size() > kMostFailures) order.resize(kMostFailures);
  for (const auto& [count, cause] : order) {
    const std::size_t level = worst.at(cause);
    const auto index = static_cast<std::size_t>(failures(level).at(cause).scenario);
    PRIMO_ASSIGN(auto scenario, held_out_scenario(workers_.robot(), part_, level, index));
    PRIMO_ASSIGN(auto seen, estimate(scenario));
    auto failed = motion(held_out_rollout(part_, level, index, std::move(scenario), std::move(seen), primitive,
                                          physics::Mode::final_pose));
    if (!failed) continue;  // a plan without a trajectory has nothing to draw
    FailurePicture picture{optimized,
                           cause,
                           -count,
                           static_cast<int>(levels[level].strict.trials()),
                           levels[level].displacement,
                           "",
                           failed->result.verdict.reason};
    PRIMO_ASSIGN(picture.png,
                 hand_picture(*failed, std::string("failure_") + (optimized ? "after_" : "before_") + cause));
    pictures.failures.push_back(std::move(picture));
  }
  return success();
}

}  // namespace

Result<PartPictures> draw_pictures(LocalWorkers& workers, const Part& part, const PartResult& result, Journal& journal,
                                   const fs::path& folder) {
  const auto &before = result.collections.front().primitive, &after = result.collections.back().primitive;
  Artist artist(part, workers, journal, folder);
  PartPictures pictures;
  PRIMO_TRY(artist.draw_training(before, after, pictures));
  PRIMO_TRY(artist.draw_failures(result.levels, before, false, pictures));
  PRIMO_TRY(artist.draw_failures(result.levels, after, true, pictures));
  return pictures;
}

}  // namespace primo::study

#include "study/report_pictures.h"

#include <utility>

#include "core/files.h"
#include "motion/planner.h"
#include "physics/picture.h"
#include "study/codec.h"
#include "study/journal.h"
#include "study/local_workers.h"
#include "study/rollout.h"

namespace primo::study {
namespace {

namespace fs = std::filesystem;

/// One primitive in one training scenario.
struct Grasp {
  Rollout rollout;
  motion::Plan plan;
  RolloutResult result;
};

class Artist {
 public:
  Artist(const Study& study, LocalWorkers& workers, Journal& journal, fs::path folder)
      : study_(study), workers_(workers), journal_(journal), folder_(std::move(folder)) {}

  Result<Pictures> draw(const motion::Primitive& before, const motion::Primitive& after);

 private:
  Result<scene::SceneEstimate> estimate(const scene::Scenario& scenario);
  Result<Grasp> grasp(const motion::Primitive& primitive, std::size_t k);
  Result<std::string> motion_picture(const Grasp& grasp, const std::string& name, bool dashed) const;
  Result<std::string> hand_picture(const Grasp& grasp, const std::string& name) const;

  const Study& study_;
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

Result<Grasp> Artist::grasp(const motion::Primitive& primitive, std::size_t k) {
  Grasp grasp;
  PRIMO_ASSIGN(auto seen, estimate(study_.training[k]));
  grasp.rollout = {
      study_.training[k],        std::move(seen),      primitive, validation_seed(study_.settings.seed, 0, k),
      physics::Mode::final_pose, study_.settings.judge};
  grasp.plan = motion::plan(workers_.robot(), plan_request(grasp.rollout));
  if (!has_trajectory(grasp.plan)) {
    return Error{Code::failed, "no plan to draw in " + study_.training[k].name + ": " + grasp.plan.reason};
  }
  PRIMO_ASSIGN(grasp.result, workers_.roll_out(grasp.rollout));
  return grasp;
}

Result<std::string> Artist::motion_picture(const Grasp& grasp, const std::string& name, bool dashed) const {
  physics::MotionPictureOptions options;
  options.dashed = dashed;
  PRIMO_TRY(physics::render_motion_png(folder_ / name, workers_.robot(), grasp.rollout.scenario,
                                       grasp.plan.trajectory.q, options));
  return read_file(folder_ / name);
}

Result<std::string> Artist::hand_picture(const Grasp& grasp, const std::string& name) const {
  const Eigen::VectorXd q = grasp.plan.trajectory.q.bottomRows(1).transpose();
  physics::PictureOptions options;
  options.view = physics::close_up(workers_.robot(), grasp.rollout.scenario, q);
  options.close_hand = true;
  PRIMO_TRY(physics::render_png(folder_ / name, &workers_.robot(), grasp.rollout.scenario, q, options));
  return read_file(folder_ / name);
}

Result<Pictures> Artist::draw(const motion::Primitive& before, const motion::Primitive& after) {
  std::size_t shown = 0;
  for (std::size_t k = 0; k < study_.training.size(); ++k) {
    PRIMO_ASSIGN(const Grasp old_grasp, grasp(before, k));
    PRIMO_ASSIGN(const Grasp new_grasp, grasp(after, k));
    if (!old_grasp.result.verdict.success && new_grasp.result.verdict.success) {
      shown = k;
      break;
    }
  }
  PRIMO_ASSIGN(const Grasp old_grasp, grasp(before, shown));
  PRIMO_ASSIGN(const Grasp new_grasp, grasp(after, shown));
  Pictures pictures;
  pictures.scenario = study_.training[shown].name;
  pictures.verdict_before = old_grasp.result.verdict.reason;
  pictures.verdict_after = new_grasp.result.verdict.reason;
  const fs::path scene = folder_ / "scene.png";
  PRIMO_TRY(physics::render_png(scene, &workers_.robot(), study_.training[shown],
                                old_grasp.plan.trajectory.q.row(0).transpose()));
  PRIMO_ASSIGN(pictures.scene, read_file(scene));
  PRIMO_ASSIGN(pictures.motion_before, motion_picture(old_grasp, "motion_before.png", true));
  PRIMO_ASSIGN(pictures.motion_after, motion_picture(new_grasp, "motion_after.png", false));
  PRIMO_ASSIGN(pictures.hand_before, hand_picture(old_grasp, "hand_before.png"));
  PRIMO_ASSIGN(pictures.hand_after, hand_picture(new_grasp, "hand_after.png"));
  return pictures;
}

}  // namespace

Result<Pictures> draw_pictures(const Study& study, const StudyResult& result, const fs::path& folder) {
  PRIMO_ASSIGN(const auto workers, LocalWorkers::create(study.robot));
  PRIMO_ASSIGN(Journal journal, Journal::open_existing(journal_file(folder.parent_path())));
  return Artist(study, *workers, journal, folder)
      .draw(result.collections.front().primitive, result.collections.back().primitive);
}

}  // namespace primo::study

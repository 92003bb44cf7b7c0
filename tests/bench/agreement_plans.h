// Plans to judge twice: one a scene, so that trials are independent, with primitives that differ as those of a search
// do.
#pragma once

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/random.h"
#include "motion/planner.h"
#include "physics/place_scenes.h"
#include "scene/generator.h"
#include "study/local_workers.h"
#include "study/rollout.h"

namespace primo::bench {

struct Planned {
  study::Rollout rollout;
  motion::Plan plan;
};

/// Scenes and primitives by index; the same whichever others were asked for.
class Plans {
 public:
  Plans(const robot::Robot& robot, std::uint64_t seed, const std::string& action)
      : robot_(robot), seed_(seed), configs_(std::filesystem::path(PRIMO_SOURCE_DIR) / "configs") {
    hand_tuned_ = primitive(action + "_hand_tuned");
    reference_ = primitive(action + "_reference");
  }
  virtual ~Plans() = default;

  /// Nothing where no scene or no motion is found.
  std::optional<Planned> at(std::uint64_t index) const {
    auto scenario = scene(index);
    if (!scenario) return std::nullopt;
    Planned planned;
    study::Rollout& rollout = planned.rollout;
    rollout.scenario = std::move(*scenario);
    if (rollout.scenario.robot_start.empty())
      rollout.scenario.robot_start.assign(robot_.home().begin(), robot_.home().end());
    auto estimate = study::observe_scenario(rollout.scenario);
    if (!estimate.ok()) return std::nullopt;
    rollout.estimate = std::move(*estimate);
    rollout.primitive = primitive_at(index);
    rollout.judge_seed = index;
    rollout.mode = physics::Mode::execute;  // with gains
    planned.plan = motion::plan(robot_, study::plan_request(rollout));
    if (!study::has_trajectory(planned.plan)) return std::nullopt;
    return planned;
  }

 protected:
  virtual std::optional<scene::Scenario> scene(std::uint64_t index) const = 0;
  virtual motion::Primitive primitive_at(std::uint64_t index) const = 0;

  motion::Primitive primitive(const std::string& name) const {
    auto read = motion::read_primitive(configs_ / "primitives" / (name + ".yaml"));
    PRIMO_CHECK(read.ok(), read.error().message);
    return std::move(*read);
  }
  /// The reference with every log10 ρ moved by a normal number.
  motion::Primitive perturbed(std::uint64_t index, double deviation, const std::string& name) const {
    Random random(seed_, "perturbed reference", {index});
    auto rho = reference_.log_rho();
    for (double& value : rho) value += deviation * random.normal();
    motion::Primitive moved = reference_.with_log_rho(rho);
    if (!name.empty()) moved.name = name;
    return moved;
  }

  const robot::Robot& robot_;
  std::uint64_t seed_;
  std::filesystem::path configs_;
  motion::Primitive hand_tuned_, reference_;
};

/// Random scenes. The hand-tuned primitive in even ones; in odd ones the reference, moved by 0.5.
class GraspPlans final : public Plans {
 public:
  GraspPlans(const robot::Robot& robot, std::uint64_t seed) : Plans(robot, seed, "grasp") {}

 private:
  std::optional<scene::Scenario> scene(std::uint64_t index) const override {
    scene::RandomSceneSettings settings;
    settings.depth_noise = 0.002;
    auto scenario = scene::random_scenario(settings, seed_, index);
    if (!scenario.ok()) return std::nullopt;
    return std::move(*scenario);
  }
  motion::Primitive primitive_at(std::uint64_t index) const override {
    return index % 2 == 1 ? perturbed(index, 0.5, {}) : hand_tuned_;
  }
};

/// Random scenes and, every other time, training scenes displaced by up to 0 … 5 cm. In turn the hand-tuned primitive,
/// the reference as it is, moved by 0.5, and moved by 1.2 as a wide search moves it.
class PlacePlans final : public Plans {
 public:
  PlacePlans(const robot::Robot& robot, std::uint64_t seed) : Plans(robot, seed, "place") {
    for (int i = 1; i <= 6; ++i) {
      auto read = scene::read_scenario(configs_ / "scenarios" / ("place_" + std::to_string(i) + ".yaml"));
      PRIMO_CHECK(read.ok(), read.error().message);
      training_.push_back(std::move(*read));
    }
  }

 private:
  std::optional<scene::Scenario> scene(std::uint64_t index) const override {
    const std::uint64_t pair = index / 2;
    if (index % 2 == 0) {
      physics::PlaceSceneSettings settings;
      settings.scenes.depth_noise = 0.002;
      auto scenario = physics::random_place_scenario(robot_, settings, seed_, pair);
      if (!scenario.ok()) return std::nullopt;
      return std::move(*scenario);
    }
    const double most = 0.01 * static_cast<double>(pair / training_.size() % 6);
    auto displaced = scene::displace(robot_, training_[pair % training_.size()], most, seed_, pair);
    if (!displaced.ok()) return std::nullopt;
    return std::move(displaced->scenario);
  }
  motion::Primitive primitive_at(std::uint64_t index) const override {
    switch (index / 2 % 4) {
      case 0:
        return hand_tuned_;
      case 1:
        return reference_;
      case 2:
        return perturbed(index, 0.5, "place_reference_moved_0.5");
      default:
        return perturbed(index, 1.2, "place_reference_moved_1.2");
    }
  }

  std::vector<scene::Scenario> training_;
};

inline std::unique_ptr<Plans> plans(const robot::Robot& robot, std::uint64_t seed, bool place) {
  if (place) return std::make_unique<PlacePlans>(robot, seed);
  return std::make_unique<GraspPlans>(robot, seed);
}

}  // namespace primo::bench

// Symbols before and after an action: snapshots of the scene for predicates to look at.
//
// Mode::final_pose simulates hand and object alone, so the rest follows from how a real robot would go on
// (docs/decisions/0201): a motion that breaks limits or speeds is refused; one that touches something is stopped there,
// and what it touched lies down; a clean motion whose grasp fails leaves the object on its support, lying when it left
// the hand tilted.
#pragma once

#include <optional>
#include <string>

#include "physics/grasp_trial.h"
#include "scene/scenario.h"
#include "symbols/snapshot.h"

namespace primo::physics {

/// The scene as the scenario has it, with what the hand holds.
symbols::WorldSnapshot snapshot(const scene::Scenario& scenario);

/// Lays a body on its side where it stands: turned by 90° about a horizontal axis of its own, its lowest point as high
/// as before. A table stays.
void lay_down(symbols::WorldSnapshot& world, const std::string& name);

/// What Mode::final_pose leaves behind.
struct Aftermath {
  bool held = false;                   ///< strictly: clean path and held
  std::optional<std::string> knocked;  ///< what the path touched first
  std::optional<Pose> X_WO_target;     ///< of the target at the end of the trial, when the motion came that far
};
symbols::WorldSnapshot snapshot_after(const scene::Scenario& scenario, const std::string& target,
                                      const Aftermath& aftermath);

}  // namespace primo::physics

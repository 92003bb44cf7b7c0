// Objects that an action is not about: they cost nothing until something touches them.
#pragma once

#include <vector>

#include "physics/model.h"
#include "scene/scenario.h"

namespace primo::physics {

/// The objects of a scenario that its action does not name. They stand on the table, so they are left alone (no weight,
/// no contact with the table or each other) until the robot or an object that moves touches them; from the next step on
/// they are bodies like all others.
class Bystanders {
 public:
  Bystanders() = default;
  /// Of a model assembled by assemble().
  Bystanders(const Model& model, const scene::Scenario& scenario);
  /// Leaves all of them alone. `data` must have been reset.
  void rest(mjModel* model, mjData* data);
  /// Wakes those that are in contact. @pre contacts are up to date (mj_step1).
  void wake_touched(mjModel* model, mjData* data);
  int resting() const { return resting_; }

 private:
  struct Body {
    int body, geom;
    bool resting;
  };
  void wake(mjModel* model, mjData* data, Body& body);

  std::vector<Body> bodies_;
  std::vector<int> of_geom_;  // by geom: which of bodies_, or −1
  int resting_ = 0;
};

}  // namespace primo::physics

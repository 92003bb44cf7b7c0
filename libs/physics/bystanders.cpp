#include "physics/bystanders.h"

#include <algorithm>

namespace primo::physics {
namespace {

// A bit that whatever can move has, and the world has not.
constexpr int kMoving = 4;

}  // namespace

Bystanders::Bystanders(const Model& model, const scene::Scenario& scenario)
    : of_geom_(static_cast<std::size_t>(model->ngeom), -1) {
  for (const auto& object : scenario.objects) {
    const auto& action = scenario.action;
    if (scenario.holds(object.name) || std::find(action.begin(), action.end(), object.name) != action.end()) continue;
    const int geom = model.geom("object:" + object.name);
    of_geom_[static_cast<std::size_t>(geom)] = static_cast<int>(bodies_.size());
    bodies_.push_back({model.body(object.name), geom, false});
  }
}

void Bystanders::rest(mjModel* model, mjData* data) {
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->geom_bodyid[g] > 0 && model->geom_contype[g] != 0) model->geom_contype[g] |= kMoving;
  }
  for (auto& body : bodies_) {
    model->geom_contype[body.geom] = 0;
    model->geom_conaffinity[body.geom] = kMoving;
    for (int i = 0; i < 3; ++i)
      data->xfrc_applied[6 * body.body + i] = -model->opt.gravity[i] * model->body_mass[body.body];
    body.resting = true;
  }
  resting_ = static_cast<int>(bodies_.size());
}

void Bystanders::wake(mjModel* model, mjData* data, Body& body) {
  if (!body.resting) return;
  model->geom_contype[body.geom] = kSceneContype | kMoving;
  model->geom_conaffinity[body.geom] = kSceneConaffinity;
  std::fill_n(data->xfrc_applied + 6 * body.body, 6, 0.0);
  body.resting = false;
  --resting_;
}

void Bystanders::wake_touched(mjModel* model, mjData* data) {
  if (resting_ == 0) return;
  for (int c = 0; c < data->ncon; ++c) {
    for (const int geom : {data->contact[c].geom1, data->contact[c].geom2}) {
      if (const int i = of_geom_[static_cast<std::size_t>(geom)]; i >= 0)
        wake(model, data, bodies_[static_cast<std::size_t>(i)]);
    }
  }
}

}  // namespace primo::physics

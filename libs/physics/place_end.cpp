#include "physics/place_end.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "robot/distance.h"
#include "scene/geometry.h"

namespace primo::physics {
namespace {

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

double tilt_of(const Eigen::Matrix3d& R) { return std::acos(std::clamp(std::abs(R(2, 2)), 0.0, 1.0)); }

/// m/s, of the fastest point of a body within `radius` of its centre.
double fastest_point(const mjModel* model, const mjData* data, int body, double radius) {
  std::array<mjtNum, 6> v{};
  mj_objectVelocity(model, data, mjOBJ_BODY, body, v.data(), 0);
  return std::hypot(v[3], v[4], v[5]) + radius * std::hypot(v[0], v[1], v[2]);
}

Shape support_shape(const scene::Scenario& scenario) {
  if (const auto* object = scenario.object(scenario.action[2])) return object->shape();
  const auto& table = scenario.table;
  return {ShapeType::box, {table.size.x() / 2, table.size.y() / 2, table.thickness / 2}};
}

}  // namespace

Pose support_pose(const scene::Scenario& scenario) {
  if (const auto* object = scenario.object(scenario.action[2])) return object->X_WO();
  return pose(scenario.table.top_centre - Eigen::Vector3d(0, 0, scenario.table.thickness / 2));
}

Stacking stacking(const scene::Scenario& scenario, const Pose& X_WX, const Pose& X_WY) {
  const scene::Object& x = *scenario.object(scenario.action[1]);
  const Shape y = support_shape(scenario);
  const Eigen::Vector3d apart = X_WX.translation() - X_WY.translation();
  // Half heights are those of the bodies standing: what a leaning one lacks is a wrong height.
  const auto half_height = [](const Shape& shape) { return shape.size[shape.type == ShapeType::box ? 2 : 1]; };
  Stacking s;
  s.height = apart.z() - half_height(x.shape()) - half_height(y);
  s.offset = apart.head<2>().norm();
  if (!scenario.object(scenario.action[2])) {
    const Eigen::Vector2d beyond = apart.head<2>().cwiseAbs() - y.size.head<2>();
    s.offset = beyond.cwiseMax(0).norm();
  }
  s.tilt = tilt_of(X_WX.linear());
  s.overlap = std::max(0.0, -robot::distance(x.shape(), X_WX, y, X_WY).distance);
  return s;
}

PlaceBodies::PlaceBodies(const Model& model, const scene::Scenario& scenario) {
  const std::string &x = scenario.action[1], &y = scenario.action[2];
  object_body = model.body(x);
  object_geom = model.geom("object:" + x);
  support_body = scenario.object(y) ? model.body(y) : 0;
  support_geom = scenario.object(y) ? model.geom("object:" + y) : model.geom(y);
  PRIMO_CHECK(object_body > 0 && object_geom >= 0 && support_body >= 0 && support_geom >= 0,
              "the model holds the object and its support");
}

void PlaceObserver::note_contacts(const mjModel* model, const mjData* data) {
  touches_hand_ = touches_hand_ || joints_.touches_robot(model, data, bodies_.object_geom);
  for (int c = 0; c < data->ncon; ++c) {
    const auto& contact = data->contact[c];
    if (contact.exclude != 0) continue;
    const auto [low, high] = std::minmax(contact.geom1, contact.geom2);
    const auto [a, b] = std::minmax(bodies_.object_geom, bodies_.support_geom);
    touches_support_ = touches_support_ || (low == a && high == b);
  }
}

void PlaceObserver::forget_contacts() { touches_support_ = touches_hand_ = false; }

double PlaceObserver::speed(const mjModel* model, const mjData* data) const {
  const double x = fastest_point(model, data, bodies_.object_body, model->geom_rbound[bodies_.object_geom]);
  if (bodies_.support_body == 0) return x;
  return std::max(x, fastest_point(model, data, bodies_.support_body, model->geom_rbound[bodies_.support_geom]));
}

PlaceEnd PlaceObserver::end(const mjModel* model, const mjData* data) const {
  PlaceEnd end;
  const Pose before = support_pose(scenario_);
  const Pose X_WY = bodies_.support_body > 0 ? body_pose(data, bodies_.support_body) : before;
  end.found = stacking(scenario_, body_pose(data, bodies_.object_body), X_WY);
  end.speed = speed(model, data);
  end.support_tilt = std::acos(std::clamp(X_WY.linear().col(2).dot(before.linear().col(2)), -1.0, 1.0));
  end.touches_support = touches_support_;
  end.touches_hand = touches_hand_;
  return end;
}

std::vector<Criterion> place_criteria(const PlaceEnd& end, const JudgeSettings& settings) {
  const auto below = [](const char* name, double value, double margin) {
    return Criterion{name, value, margin, value <= margin};
  };
  std::vector<Criterion> all = {below("place_height", std::abs(end.found.height), settings.place_height),
                                below("place_offset", end.found.offset, settings.place_offset),
                                below("place_tilt", end.found.tilt, settings.place_tilt),
                                below("place_speed", end.speed, settings.place_speed),
                                {"place_on_support", end.touches_support ? 1.0 : 0.0, 1.0, end.touches_support},
                                {"place_off_hand", end.touches_hand ? 0.0 : 1.0, 1.0, !end.touches_hand},
                                below("place_support_tilt", end.support_tilt, settings.place_tilt)};
  const bool on = std::all_of(all.begin(), all.end(), [](const Criterion& c) { return c.met; });
  const bool on_paper = std::abs(end.planned.height) <= settings.place_height;
  all.push_back({"on", on ? 1.0 : 0.0, 1.0, on});
  all.push_back({"on_paper", on_paper ? 1.0 : 0.0, 1.0, on_paper});
  return all;
}

double place_score(const Stacking& planned, const JudgeSettings& settings) {
  const double near = std::exp(-planned.offset / 0.05 - std::abs(planned.height) / 0.05 - planned.tilt / 0.5);
  return 0.7 * near * std::exp(-std::max(0.0, planned.overlap - settings.max_penetration) / 0.01);
}

PlaceDecision decide_place(const PlaceEnd& end, const JudgeSettings& settings) {
  const auto criteria = place_criteria(end, settings);
  const bool on = criteria[criteria.size() - 2].met, on_paper = criteria.back().met;
  PlaceDecision decision;
  if (settings.place_criterion == PlaceCriterion::paper) {
    decision.reason = "at the end of the motion the object is " + text("%.1f mm", 1e3 * end.planned.height) +
                      " above its height on the support";
    decision.outcome = on_paper ? Outcome::placed : Outcome::not_on;
  } else if (on) {
    decision.outcome = Outcome::placed;
    decision.reason =
        "the object stands on its support, " + text("%.1f mm", 1e3 * end.found.offset) + " off its centre";
  } else if (end.touches_hand) {
    decision.outcome = Outcome::not_released;
    decision.reason = "the opened and withdrawn hand still touches the object";
  } else if (end.support_tilt > settings.place_tilt) {
    decision.outcome = Outcome::support_fell;
    decision.reason = "the support fell over";
  } else {
    decision.reason = "the object is not on its support:";
    for (std::size_t i = 0; i + 2 < criteria.size(); ++i) {
      if (!criteria[i].met)
        decision.reason +=
            " " + criteria[i].name + text(" %.3g", criteria[i].value) + text(" against %.3g", criteria[i].margin);
    }
  }
  decision.score = place_score(end.planned, settings);
  if (decision.outcome == Outcome::placed)
    decision.score = 0.8 + 0.2 * (1 - std::min(1.0, end.found.offset / settings.place_offset));
  return decision;
}

Eigen::VectorXd opening_targets(const robot::Robot& robot, const Eigen::VectorXd& holding, double seconds) {
  const double x = std::clamp(seconds / kOpenSeconds, 0.0, 1.0), s = x * x * (3 - 2 * x);
  Eigen::VectorXd targets = holding;
  for (int i = 0; i < robot.hand_joints(); ++i) {
    if (robot.file().hand[static_cast<std::size_t>(i)].closing == 0) continue;
    targets[i] += s * (robot.home()[robot.arm_joints() + i] - holding[i]);
  }
  return targets;
}

}  // namespace primo::physics

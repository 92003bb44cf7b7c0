#include "study/codec.h"

#include <utility>

#include "study/json_io.h"

namespace primo::study {
namespace {

using json::Json;

Json to_json(const physics::Survival& s) {
  return {{"amplitude", json::number(s.amplitude)},
          {"seeds", s.seeds},
          {"held", s.held},
          {"survival", json::number(s.survival)},
          {"displacement", json::number(s.displacement)}};
}

physics::Survival survival_from(const Json& at) {
  physics::Survival s;
  json::get(at, "amplitude", s.amplitude);
  json::get(at, "seeds", s.seeds);
  json::get(at, "held", s.held);
  json::get(at, "survival", s.survival);
  json::get(at, "displacement", s.displacement);
  return s;
}

Json to_json(const physics::Contact& c) {
  return {{"first", c.first},
          {"second", c.second},
          {"begin", json::number(c.begin)},
          {"end", json::number(c.end)},
          {"peak_force", json::number(c.peak_force)}};
}

physics::Contact contact_from(const Json& at) {
  physics::Contact c;
  json::get(at, "first", c.first);
  json::get(at, "second", c.second);
  json::get(at, "begin", c.begin);
  json::get(at, "end", c.end);
  json::get(at, "peak_force", c.peak_force);
  return c;
}

template <class T>
Json list_of(const std::vector<T>& values) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(to_json(value));
  return list;
}

Json to_json(const physics::Verdict& v) {
  Json criteria = Json::array();
  for (const auto& c : v.criteria) {
    criteria.push_back(
        {{"name", c.name}, {"value", json::number(c.value)}, {"margin", json::number(c.margin)}, {"met", c.met}});
  }
  return {{"success", v.success},
          {"final_pose_success", v.final_pose_success},
          {"path_clean", v.path_clean},
          {"outcome", config::enum_name(v.outcome)},
          {"reason", v.reason},
          {"score", json::number(v.score)},
          {"displacement", json::number(v.displacement)},
          {"survival", json::number(v.survival)},
          {"position_error", json::number(v.position_error)},
          {"clearance", json::number(v.clearance)},
          {"target_clearance", json::number(v.target_clearance)},
          {"limit_margin", json::number(v.limit_margin)},
          {"max_speed", json::number(v.max_speed)},
          {"path_length", json::number(v.path_length)},
          {"criteria", std::move(criteria)},
          {"before", json::state(v.before)},
          {"after", json::state(v.after)},
          {"objects", json::strings(v.objects)},
          {"steps", v.steps},
          {"survivals", list_of(v.survivals)},
          {"contacts", list_of(v.contacts)},
          {"unlisted_contacts", v.unlisted_contacts}};
}

physics::Verdict verdict_from(const Json& at) {
  physics::Verdict v;
  json::get(at, "success", v.success);
  json::get(at, "final_pose_success", v.final_pose_success);
  json::get(at, "path_clean", v.path_clean);
  json::get(at, "outcome", v.outcome);
  json::get(at, "reason", v.reason);
  json::get(at, "score", v.score);
  json::get(at, "displacement", v.displacement);
  json::get(at, "survival", v.survival);
  json::get(at, "position_error", v.position_error);
  json::get(at, "clearance", v.clearance);
  json::get(at, "target_clearance", v.target_clearance);
  json::get(at, "limit_margin", v.limit_margin);
  json::get(at, "max_speed", v.max_speed);
  json::get(at, "path_length", v.path_length);
  for (const auto& c : json::array(at, "criteria")) {
    physics::Criterion criterion;
    json::get(c, "name", criterion.name);
    json::get(c, "value", criterion.value);
    json::get(c, "margin", criterion.margin);
    json::get(c, "met", criterion.met);
    v.criteria.push_back(std::move(criterion));
  }
  json::get(at, "before", v.before);
  json::get(at, "after", v.after);
  json::get(at, "objects", v.objects);
  json::get(at, "steps", v.steps);
  for (const auto& row : json::array(at, "survivals")) v.survivals.push_back(survival_from(row));
  for (const auto& contact : json::array(at, "contacts")) v.contacts.push_back(contact_from(contact));
  json::get(at, "unlisted_contacts", v.unlisted_contacts);
  return v;
}

}  // namespace

std::string encode(const RolloutResult& result) {
  return symbols::dump({{"plan_status", config::enum_name(result.plan_status)},
                        {"plan_reason", result.plan_reason},
                        {"iterations", result.iterations},
                        {"plan_cost", json::number(result.plan_cost)},
                        {"verdict", to_json(result.verdict)}});
}

Result<RolloutResult> decode_rollout_result(const std::string& text) {
  return json::decode(text, "rollout result", [](const Json& at) {
    RolloutResult result;
    json::get(at, "plan_status", result.plan_status);
    json::get(at, "plan_reason", result.plan_reason);
    json::get(at, "iterations", result.iterations);
    json::get(at, "plan_cost", result.plan_cost);
    result.verdict = verdict_from(json::field(at, "verdict"));
    return result;
  });
}

std::string encode(const scene::SceneEstimate& estimate) {
  Json objects = Json::array();
  for (const auto& o : estimate.objects) {
    objects.push_back({{"name", o.name},
                       {"type", config::enum_name(o.type)},
                       {"X_WO", json::pose(o.X_WO)},
                       {"shape", config::enum_name(o.shape.type)},
                       {"size", json::vector(o.shape.size)},
                       {"residual", json::number(o.residual)},
                       {"points", o.points}});
  }
  return symbols::dump({{"scene", estimate.scene},
                        {"table",
                         {{"name", estimate.table.name},
                          {"top_centre", json::vector(estimate.table.top_centre)},
                          {"size", json::vector(estimate.table.size)},
                          {"thickness", json::number(estimate.table.thickness)}}},
                        {"objects", std::move(objects)},
                        {"resolution", json::number(estimate.resolution)}});
}

Result<scene::SceneEstimate> decode_estimate(const std::string& text) {
  return json::decode(text, "scene estimate", [](const Json& at) {
    scene::SceneEstimate estimate;
    json::get(at, "scene", estimate.scene);
    const Json& table = json::field(at, "table");
    json::get(table, "name", estimate.table.name);
    json::get(table, "top_centre", estimate.table.top_centre);
    json::get(table, "size", estimate.table.size);
    json::get(table, "thickness", estimate.table.thickness);
    for (const auto& o : json::array(at, "objects")) {
      scene::ObjectEstimate object;
      json::get(o, "name", object.name);
      json::get(o, "type", object.type);
      json::get(o, "X_WO", object.X_WO);
      json::get(o, "shape", object.shape.type);
      json::get(o, "size", object.shape.size);
      json::get(o, "residual", object.residual);
      json::get(o, "points", object.points);
      estimate.objects.push_back(std::move(object));
    }
    json::get(at, "resolution", estimate.resolution);
    return estimate;
  });
}

std::string encode(const OptimizeResult& result) {
  return symbols::dump({{"study", result.study},
                        {"round", result.round},
                        {"primitive", config::dump(result.primitive)},
                        {"gamma", json::number(result.gamma)},
                        {"success", json::rate(result.success)},
                        {"evaluations", result.evaluations}});
}

Result<OptimizeResult> decode_optimize_result(const std::string& text) {
  return json::decode(text, "optimization result", [](const Json& at) {
    OptimizeResult result;
    json::get(at, "study", result.study);
    json::get(at, "round", result.round);
    std::string primitive;
    json::get(at, "primitive", primitive);
    auto read = config::read_text<motion::Primitive>(primitive, "primitive");
    if (!read) throw json::Malformed{read.error().message};
    result.primitive = std::move(*read);
    json::get(at, "gamma", result.gamma);
    json::get(at, "success", result.success);
    json::get(at, "evaluations", result.evaluations);
    return result;
  });
}

}  // namespace primo::study

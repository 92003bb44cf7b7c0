#include "physics/contact_log.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace primo::physics {
namespace {

std::string name_of(const mjModel* model, int geom) {
  const int body = model->geom_bodyid[geom];
  const char* name = body > 0 ? mj_id2name(model, mjOBJ_BODY, body) : mj_id2name(model, mjOBJ_GEOM, geom);
  if (name && *name) return name;
  return body > 0 ? "body " + std::to_string(body) : "geom " + std::to_string(geom);
}

}  // namespace

ContactLog::ContactLog(const mjModel* model) : label_of_geom_(static_cast<std::size_t>(model->ngeom), 0) {
  // Geoms of one body share a label; those of the world are told apart. The robot's come first, so that a pair is
  // always named from the robot's side.
  std::map<std::pair<int, int>, int> labels;
  for (const bool of_robot : {true, false}) {
    for (int g = 0; g < model->ngeom; ++g) {
      if ((model->geom_group[g] == kRobotGroup) != of_robot) continue;
      const int body = model->geom_bodyid[g];
      const auto [at, fresh] = labels.try_emplace({body, body > 0 ? -1 : g}, static_cast<int>(labels.size()));
      if (fresh) name_of_label_.push_back(g);
      label_of_geom_[static_cast<std::size_t>(g)] = at->second;
    }
  }
  labels_ = static_cast<int>(labels.size());
  entry_of_pair_.assign(static_cast<std::size_t>(labels_) * static_cast<std::size_t>(labels_), kNever);
}

int ContactLog::entry(const mjModel* model, int a, int b, double time) {
  if (a > b) std::swap(a, b);
  int& at =
      entry_of_pair_[static_cast<std::size_t>(a) * static_cast<std::size_t>(labels_) + static_cast<std::size_t>(b)];
  if (at != kNever) return at;
  if (contacts_.size() >= static_cast<std::size_t>(Verdict::kMostContacts)) {
    ++unlisted_;
    return at = kUnlisted;
  }
  at = static_cast<int>(contacts_.size());
  const auto name = [&](int label) { return name_of(model, name_of_label_[static_cast<std::size_t>(label)]); };
  contacts_.push_back({name(a), name(b), time, time, 0});
  forces_.emplace_back();
  return at;
}

void ContactLog::record(const mjModel* model, const mjData* data, double time) {
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.exclude != 0) continue;
    const int at = entry(model, label_of_geom_[static_cast<std::size_t>(contact.geom1)],
                         label_of_geom_[static_cast<std::size_t>(contact.geom2)], time);
    if (at < 0) continue;
    std::array<mjtNum, 6> force{};
    mj_contactForce(model, data, c, force.data());
    auto& sum = forces_[static_cast<std::size_t>(at)];
    if (sum.step != step_) sum = {step_, 0};
    sum.sum += force[0];  // along the normal
    auto& pair = contacts_[static_cast<std::size_t>(at)];
    pair.end = time;
    pair.peak_force = std::max(pair.peak_force, sum.sum);
  }
  ++step_;
}

}  // namespace primo::physics

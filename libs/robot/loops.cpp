#include "robot/loops.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <set>

#include "robot/mjcf.h"
#include "robot/settling.h"

namespace primo::robot {
namespace {

constexpr int kParts = 64;          // of a curve; values are right to the third power of one
constexpr int kWayHome = 32;        // steps from where the model is assembled to the hand's home
constexpr double kMostOpen = 1e-3;  // m, rad

/// Sets of joints that belong together.
class Groups {
 public:
  explicit Groups(int count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int of(int i) const {
    while (parent_[static_cast<std::size_t>(i)] != i) i = parent_[static_cast<std::size_t>(i)];
    return i;
  }
  void join(int a, int b) { parent_[static_cast<std::size_t>(of(a))] = of(b); }
  void join(const std::vector<int>& all) {
    for (const int i : all) join(i, all.front());
  }

 private:
  std::vector<int> parent_;
};

/// Joints in loops that one listed joint leads.
struct Mechanism {
  std::vector<int> joints;  ///< whose drives are to be found
  int leader = -1;          ///< by index of q; −1: none
};

class LoopSolver {
 public:
  LoopSolver(const mjModel& model, const std::string& where, const ListedJoints& listed, std::vector<Drive>& drives)
      : model_(model), where_(where), listed_(listed), drives_(drives), groups_(model.njnt + count(listed)) {}

  Result<std::vector<Loop>> solve() {
    PRIMO_TRY(find_loops());
    if (loops_.empty()) return loops_;
    PRIMO_TRY(find_mechanisms());
    std::vector<char> free(static_cast<std::size_t>(model_.njnt), 0);
    for (const auto& mechanism : mechanisms_) {
      for (const int j : mechanism.joints) free[static_cast<std::size_t>(j)] = 1;
    }
    settling_.emplace(model_, free);
    PRIMO_TRY(go_home());
    const Eigen::VectorXd home = settling_->state();
    for (const auto& mechanism : mechanisms_) {
      settling_->set_state(home);
      if (mechanism.joints.empty()) continue;
      if (mechanism.leader >= 0) {
        PRIMO_TRY(follow(mechanism));
      } else {
        // What no listed joint leads stays where it comes to rest.
        for (const int j : mechanism.joints) drives_[static_cast<std::size_t>(j)] = {0, settling_->at(j), 0, nullptr};
      }
    }
    return loops_;
  }

 private:
  static int count(const ListedJoints& listed) { return static_cast<int>(listed.names.size()); }
  const Drive& drive(int j) const { return drives_[static_cast<std::size_t>(j)]; }
  std::string body(int b) const { return "'" + name_of(model_, mjOBJ_BODY, b) + "'"; }
  std::string joint(int j) const { return "'" + name_of(model_, mjOBJ_JOINT, j) + "'"; }
  std::string leader(int i) const { return "'" + listed_.names[static_cast<std::size_t>(i)] + "'"; }
  std::string text(const Loop& loop) const { return "bodies " + body(loop.body) + " and " + body(loop.other); }
  Error refuse(const std::string& message) const { return {Code::config, where_ + " " + message}; }

  std::set<int> joints_above(int b) const {
    std::set<int> joints;
    for (; b > 0; b = model_.body_parentid[b]) {
      for (int j = model_.body_jntadr[b]; j >= 0 && j < model_.body_jntadr[b] + model_.body_jntnum[b]; ++j)
        joints.insert(j);
    }
    return joints;
  }

  bool of_hand(int b) const {
    for (b = model_.body_parentid[b]; b > 0; b = model_.body_parentid[b]) {
      if (b == listed_.tool_body) return true;
    }
    return false;
  }

  Status find_loops() {
    for (int e = 0; e < model_.neq; ++e) {
      if (!model_.eq_active[e] || (model_.eq_type[e] != mjEQ_CONNECT && model_.eq_type[e] != mjEQ_WELD)) continue;
      const Loop loop{model_.eq_obj1id[e], model_.eq_obj2id[e]};
      const std::set<int> a = joints_above(loop.body), b = joints_above(loop.other);
      std::vector<int> between;  // joints that move one against the other
      std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(between));
      for (const int j : between) {
        const bool of_arm = drive(j).index >= 0 && drive(j).index < listed_.arm && drive(j).ratio != 0;
        if (of_hand(model_.jnt_bodyid[j]) && !of_arm) continue;
        return refuse("closes a loop through joint " + joint(j) + " of the arm with an equality of " + text(loop) +
                      "; only the hand, beyond the last arm joint, may have loops: an arm is an open chain");
      }
      if (between.empty()) continue;  // the bodies are one
      for (const int j : between) {
        if (model_.jnt_type[j] != mjJNT_HINGE && model_.jnt_type[j] != mjJNT_SLIDE)
          return refuse("has ball or free joint " + joint(j) + " in a loop; joints must be hinges or slides");
      }
      groups_.join(between);
      loops_.push_back(loop);
      first_joint_.push_back(between.front());
    }
    return success();
  }

  bool unknown(int j) const { return drive(j).index < 0; }

  /// Joins what equalities and tendons couple to a joint that is not known yet.
  void join_if_unknown(const std::vector<int>& joints) {
    if (std::any_of(joints.begin(), joints.end(), [this](int j) { return unknown(j); })) groups_.join(joints);
  }

  std::vector<int> joints_of_tendon(int t) const {
    std::vector<int> joints;
    for (int w = model_.tendon_adr[t]; w < model_.tendon_adr[t] + model_.tendon_num[t]; ++w) {
      if (model_.wrap_type[w] == mjWRAP_JOINT) joints.push_back(model_.wrap_objid[w]);
    }
    return joints;
  }

  void join_coupled() {
    for (int e = 0; e < model_.neq; ++e) {
      const int type = model_.eq_type[e];
      if (!model_.eq_active[e] || (type != mjEQ_JOINT && type != mjEQ_TENDON)) continue;
      std::vector<int> joints;
      for (const int id : {model_.eq_obj1id[e], model_.eq_obj2id[e]}) {
        if (id < 0) continue;
        const std::vector<int> more = type == mjEQ_JOINT ? std::vector<int>{id} : joints_of_tendon(id);
        joints.insert(joints.end(), more.begin(), more.end());
      }
      join_if_unknown(joints);
    }
    for (int t = 0; t < model_.ntendon; ++t) {
      if (model_.tendon_stiffness[t] != 0 || model_.tendon_limited[t]) join_if_unknown(joints_of_tendon(t));
    }
    for (int j = 0; j < model_.njnt; ++j) {
      if (!unknown(j) && drive(j).ratio != 0) groups_.join(j, model_.njnt + drive(j).index);
    }
  }

  Status find_mechanisms() {
    join_coupled();
    std::set<int> seen;
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      const int group = groups_.of(first_joint_[l]);
      if (!seen.insert(group).second) continue;
      Mechanism mechanism;
      for (int j = 0; j < model_.njnt; ++j) {
        if (unknown(j) && groups_.of(j) == group) mechanism.joints.push_back(j);
      }
      for (int i = 0; i < count(listed_); ++i) {
        if (groups_.of(model_.njnt + i) != group) continue;
        if (mechanism.leader >= 0) {
          return refuse("closes a loop with an equality of " + text(loops_[l]) + " that both " +
                        leader(mechanism.leader) + " and " + leader(i) +
                        " lead; of the joints that are in loops together, one must be listed in the robot file");
        }
        mechanism.leader = i;
      }
      mechanisms_.push_back(std::move(mechanism));
    }
    return success();
  }

  /// Puts all joints whose drives are known to where these values of q have them.
  void lead(const Eigen::VectorXd& q) {
    for (int j = 0; j < model_.njnt; ++j) {
      if (!unknown(j)) settling_->set(j, drive(j).offset + drive(j).ratio * q[drive(j).index]);
    }
  }

  std::string complaint(const Settling::Rest& rest) const {
    if (!rest.found) return "does not come to rest";
    char open[48];
    std::snprintf(open, sizeof open, "%.3g mm (or mrad)", 1e3 * rest.open);
    if (rest.joint >= 0)
      return std::string("only closes with joint ") + joint(rest.joint) + " beyond its range, by " + open;
    std::string what;
    const int e = rest.equality;
    if (e >= 0 && (model_.eq_type[e] == mjEQ_CONNECT || model_.eq_type[e] == mjEQ_WELD))
      what = " at the equality of " + text({model_.eq_obj1id[e], model_.eq_obj2id[e]});
    return "stays open by " + std::string(open) + what;
  }

  /// From where the model is assembled (all joints at their reference) to the hand's home.
  Status go_home() {
    Eigen::VectorXd reference = listed_.home;
    for (int j = 0; j < model_.njnt; ++j) {
      const int i = drive(j).index;
      if (i >= 0 && name_of(model_, mjOBJ_JOINT, j) == listed_.names[static_cast<std::size_t>(i)])
        reference[i] = model_.qpos0[model_.jnt_qposadr[j]];
    }
    Settling::Rest rest;
    for (int k = 0; k <= kWayHome; ++k) {
      const double s = static_cast<double>(k) / kWayHome;
      lead((1 - s) * reference + s * listed_.home);
      rest = settling_->settle(k == kWayHome);
    }
    if (!rest.found || rest.open > kMostOpen) {
      return refuse("has a loop of the hand that " + complaint(rest) +
                    " where the robot file's home has the hand; give it a home in which it closes, or correct the "
                    "anchor, the places of its bodies or the ranges of its joints");
    }
    if (rest.unheld >= 0) {
      return refuse(
          "leaves joint " + joint(rest.unheld) +
          " of a loop of the hand where it likes: neither the loop nor a spring, a coupling or a limit that it "
          "rests on holds it; give it one of these");
    }
    return success();
  }

  /// The mechanism with its leader at q and all else at home, from where it is now.
  Settling::Rest settle_at(const Mechanism& mechanism, double q) {
    Eigen::VectorXd all = listed_.home;
    all[mechanism.leader] = q;
    lead(all);
    return settling_->settle();
  }

  /// How far the leader can go from home towards `end` with the loop closed, in kParts steps and then as exactly as a
  /// thousandth of one.
  double reach(const Mechanism& mechanism, double end) {
    const double home = listed_.home[mechanism.leader], step = (end - home) / kParts;
    double good = home, bad = home;
    Eigen::VectorXd state = settling_->state();
    const auto closes = [&](double q) {
      if (!settle_at(mechanism, q).closed()) {
        settling_->set_state(state);
        return false;
      }
      good = q;
      state = settling_->state();
      return true;
    };
    for (int k = 1; k <= kParts; ++k) {
      bad = k == kParts ? end : home + k * step;
      if (!closes(bad)) break;
    }
    if (good == end) return end;
    for (int k = 0; k < 10; ++k) {
      const double middle = good + (bad - good) / 2;
      if (!closes(middle)) bad = middle;
    }
    // Just before a dead point the joints turn ever faster: stay off it.
    return home + 0.98 * (good - home);
  }

  Status follow(const Mechanism& mechanism) {
    const int i = mechanism.leader;
    const Eigen::VectorXd at_home = settling_->state();
    const auto from_home = [&](auto move) {
      settling_->set_state(at_home);
      return move();
    };
    const double lower = from_home([&] { return reach(mechanism, listed_.lower[i]); });
    const double upper = from_home([&] { return reach(mechanism, listed_.upper[i]); });
    if (!(lower < upper)) {
      return refuse(
          "has a loop of the hand that joint " + leader(i) +
          " leads and that closes only where the robot file's home has it; it must close in a range about it");
    }
    listed_.lower[i] = lower;
    listed_.upper[i] = upper;
    const double step = (upper - lower) / kParts;
    std::vector<std::vector<double>> values(mechanism.joints.size(), std::vector<double>(kParts + 1));
    const auto sample = [&](int k) {
      settle_at(mechanism, k == kParts ? upper : lower + k * step);
      for (std::size_t n = 0; n < mechanism.joints.size(); ++n)
        values[n][static_cast<std::size_t>(k)] = settling_->at(mechanism.joints[n]);
    };
    const int first = std::clamp(static_cast<int>(std::ceil((listed_.home[i] - lower) / step)), 0, kParts);
    from_home([&] {
      for (int k = first; k <= kParts; ++k) sample(k);
    });
    from_home([&] {
      for (int k = first - 1; k >= 0; --k) sample(k);
    });
    std::vector<std::shared_ptr<const Curve>> curves;
    for (auto& value : values) curves.push_back(std::make_shared<const Curve>(lower, step, std::move(value)));
    PRIMO_TRY(check_between(mechanism, curves));
    for (std::size_t n = 0; n < curves.size(); ++n) {
      drives_[static_cast<std::size_t>(mechanism.joints[n])] = {i, 0, curves[n]->steepest(), curves[n]};
    }
    return success();
  }

  /// The loop must also be closed half-way between the curves' points.
  Status check_between(const Mechanism& mechanism, const std::vector<std::shared_ptr<const Curve>>& curves) {
    const int i = mechanism.leader;
    Eigen::VectorXd q = listed_.home;
    for (int k = 0; k < 2 * kParts; ++k) {
      q[i] = listed_.lower[i] + (k + 0.5) / (2 * kParts) * (listed_.upper[i] - listed_.lower[i]);
      lead(q);
      for (std::size_t n = 0; n < curves.size(); ++n) settling_->set(mechanism.joints[n], curves[n]->value(q[i]));
      const Settling::Rest rest = settling_->measure();
      if (rest.open <= kMostOpen) continue;
      return refuse("has a loop of the hand that turns too suddenly about " + leader(i) + " = " + std::to_string(q[i]) +
                    ": read at " + std::to_string(kParts + 1) + " places of the joint's range, it " + complaint(rest) +
                    "; narrow the range to where it moves smoothly");
    }
    return success();
  }

  const mjModel& model_;
  const std::string& where_;
  const ListedJoints& listed_;
  std::vector<Drive>& drives_;
  Groups groups_;  // of MJCF joints, then listed joints
  std::vector<Loop> loops_;
  std::vector<int> first_joint_;  // by loop
  std::vector<Mechanism> mechanisms_;
  std::optional<Settling> settling_;
};

}  // namespace

Result<std::vector<Loop>> close_loops(const mjModel& model, const std::string& where, const ListedJoints& listed,
                                      std::vector<Drive>& drives) {
  return LoopSolver(model, where, listed, drives).solve();
}

}  // namespace primo::robot

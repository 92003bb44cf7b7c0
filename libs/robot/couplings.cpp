#include "robot/couplings.h"

#include <cmath>
#include <map>

#include "robot/mjcf.h"

namespace primo::robot {
namespace {

/// Σ_j coefficient_j (q_j − q_j0) = constant, by MJCF joint.
struct Row {
  std::string name;
  std::map<int, double> coefficients;
  double constant = 0;
  bool used = false;
};

class CouplingSolver {
 public:
  CouplingSolver(const mjModel& model, const std::string& where, std::vector<Drive>& drives)
      : model_(model), where_(where), drives_(drives) {}

  Status solve() {
    PRIMO_TRY(check_tendons());
    for (int e = 0; e < model_.neq; ++e) {
      if (model_.eq_active[e]) PRIMO_TRY(add_row(e));
    }
    // A follower may lead another: as long as a row has one joint left to solve for.
    for (bool more = true; more;) {
      more = false;
      for (auto& row : rows_) {
        if (row.used || unknowns(row).size() > 1) continue;
        PRIMO_TRY(use(row));
        more = true;
      }
    }
    return success();
  }

 private:
  Error refuse(const std::string& message) const { return {Code::config, where_ + " " + message}; }

  bool fixed(int tendon) const { return model_.wrap_type[model_.tendon_adr[tendon]] == mjWRAP_JOINT; }

  Status check_tendons() const {
    for (int t = 0; t < model_.ntendon; ++t) {
      if (fixed(t)) continue;
      const bool pulls = model_.tendon_stiffness[t] != 0 || model_.tendon_damping[t] != 0 ||
                         model_.tendon_frictionloss[t] != 0 || model_.tendon_limited[t];
      if (!pulls) continue;  // without its actuator it does nothing
      return refuse("has tendon '" + name_of(model_, mjOBJ_TENDON, t) +
                    "' through sites, with a spring, damping, friction or limit; only <fixed> tendons can be read");
    }
    return success();
  }

  Status add_row(int e) {
    const int type = model_.eq_type[e];
    const std::string name = name_of(model_, mjOBJ_EQUALITY, e);
    if (type != mjEQ_JOINT && type != mjEQ_TENDON) return success();  // a loop
    const mjtNum* a = model_.eq_data + mjNEQDATA * e;
    Row row{name, {}, a[0]};
    for (const int side : {0, 1}) {
      const int id = side == 0 ? model_.eq_obj1id[e] : model_.eq_obj2id[e];
      if (id < 0) continue;
      const double factor = side == 0 ? 1.0 : -a[1];
      if (type == mjEQ_JOINT) {
        if (side == 0) row.name = name_of(model_, mjOBJ_JOINT, id);
        row.coefficients[id] += factor;
      } else if (!fixed(id)) {
        return refuse("couples tendon '" + name_of(model_, mjOBJ_TENDON, id) +
                      "', which runs through sites; only <fixed> tendons can be coupled");
      } else {
        for (int w = model_.tendon_adr[id]; w < model_.tendon_adr[id] + model_.tendon_num[id]; ++w)
          row.coefficients[model_.wrap_objid[w]] += factor * model_.wrap_prm[w];
      }
    }
    if (a[2] != 0 || a[3] != 0 || a[4] != 0) {
      return refuse("couples joint '" + row.name +
                    "' by a polynomial; only linear couplings (polycoef a0 a1 0 0 0) can be planned with");
    }
    rows_.push_back(std::move(row));
    return success();
  }

  std::vector<int> unknowns(const Row& row) const {
    std::vector<int> joints;
    for (const auto& [joint, coefficient] : row.coefficients) {
      if (drives_[joint].index < 0 && coefficient != 0) joints.push_back(joint);
    }
    return joints;
  }

  /// Solves a row for its one unknown joint; with none it must say nothing new.
  Status use(Row& row) {
    row.used = true;
    const auto unknown = unknowns(row);
    const int follower = unknown.empty() ? -1 : unknown.front();
    int index = -1;
    double constant = row.constant, slope = 0;
    std::string leaders;
    for (const auto& [joint, coefficient] : row.coefficients) {
      if (joint == follower || coefficient == 0) continue;
      const Drive& drive = drives_[joint];
      leaders += (leaders.empty() ? "'" : ", '") + name_of(model_, mjOBJ_JOINT, joint) + "'";
      constant -= coefficient * (drive.offset - model_.qpos0[model_.jnt_qposadr[joint]]);
      slope += coefficient * drive.ratio;
      if (drive.ratio == 0) continue;
      if (index >= 0 && index != drive.index) return wrong(row, leaders);
      index = drive.index;
    }
    if (follower < 0) {
      const bool idle = std::abs(slope) < 1e-9 && std::abs(constant) < 1e-9;
      return idle ? success() : wrong(row, leaders);
    }
    const double own = row.coefficients.at(follower);
    // A joint that follows none stays where the equality puts it.
    drives_[follower] = {std::max(index, 0), model_.qpos0[model_.jnt_qposadr[follower]] + constant / own,
                         index < 0 ? 0.0 : -slope / own, nullptr};
    return success();
  }

  Status wrong(const Row& row, const std::string& leaders) const {
    return refuse("couples joint '" + row.name + "' to " + leaders +
                  "; one of them must be listed in the robot file, and the others must not");
  }

  const mjModel& model_;
  const std::string& where_;
  std::vector<Drive>& drives_;
  std::vector<Row> rows_;
};

}  // namespace

Status solve_couplings(const mjModel& model, const std::string& where, std::vector<Drive>& drives) {
  return CouplingSolver(model, where, drives).solve();
}

}  // namespace primo::robot

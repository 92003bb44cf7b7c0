// Who touched whom while a motion was executed, when, and how hard.
#pragma once

#include <vector>

#include "physics/model.h"
#include "physics/verdict.h"

namespace primo::physics {

/// A bounded list of pairs of bodies that touched. A geom of the world body counts under its own name (table, floor),
/// any other under its body's. For one simulation of one model.
class ContactLog {
 public:
  ContactLog() = default;
  explicit ContactLog(const mjModel* model);

  /// Adds the contacts of the step just made. `time` in s.
  /// @pre the forces of `data` are those of its contacts: after mj_step2, before the next mj_step1.
  void record(const mjModel* model, const mjData* data, double time);

  /// In the order of their beginnings.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// Pairs that touched after the list was full.
  int unlisted() const { return unlisted_; }

 private:
  struct Force {
    long step = -1;  ///< whose forces are in `sum`
    double sum = 0;  ///< N
  };
  int entry(const mjModel* model, int a, int b, double time);

  static constexpr int kNever = -1, kUnlisted = -2;
  std::vector<int> label_of_geom_;  // robot's bodies first, then the scene's
  std::vector<int> name_of_label_;  // a geom with this label
  int labels_ = 0;
  std::vector<int> entry_of_pair_;  // labels × labels: index into contacts_, or kNever or kUnlisted
  std::vector<Contact> contacts_;
  std::vector<Force> forces_;  // by entry
  long step_ = 0;
  int unlisted_ = 0;
};

}  // namespace primo::physics

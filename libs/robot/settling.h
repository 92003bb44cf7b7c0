// Where the joints of a mechanism come to rest while others are held.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "robot/mjcf.h"

namespace primo::robot {

/// A model whose free joints come to rest, without gravity, contact and friction: the least energy of its springs that
/// its equalities and the joints' limits allow, nearest to where the joints are.
///
/// Each step is one of sequential quadratic programming, min ½ dᵀ M d + ∇V(q)ᵀ d so that the constraints, linear about
/// q, hold at q + d: which is what MuJoCo's solver computes as the acceleration of a body at rest when the constraints'
/// stiffness is 1/s² and the inertia M. M is diagonal, of the springs' stiffness; where loaded constraints are curved
/// that may be too little, and steps that go back and forth are shortened. At the end springs are left out, so that
/// constraints are not stretched by them.
class Settling {
 public:
  /// free: by joint, which come to rest; all joints must be hinges or slides.
  Settling(const mjModel& model, const std::vector<char>& free);

  void set(int joint, double value) { data_->qpos[model_->jnt_qposadr[joint]] = value; }
  double at(int joint) const { return data_->qpos[model_->jnt_qposadr[joint]]; }
  Eigen::VectorXd state() const { return Eigen::Map<const Eigen::VectorXd>(data_->qpos, model_->nq); }
  void set_state(const Eigen::VectorXd& state) { std::copy_n(state.data(), state.size(), data_->qpos); }

  struct Rest {
    bool found = false;   ///< a place from which nothing moves
    double open = 0;      ///< by how much the worst constraint is not met there: m; rad of rotations
    int equality = -1;    ///< which that is
    int joint = -1;       ///< or whose limit
    int unheld = -1;      ///< a free joint that no constraint or spring holds, when asked for
    bool closed() const;  ///< at rest, and all constraints met within 0.1 mm (0.1 mrad)
  };
  /// Moves the free joints to where they come to rest.
  Rest settle(bool find_unheld = false);
  /// How far the constraints are from being met as the joints are.
  Rest measure();

 private:
  /// This part of one step. Returns the step's largest entry, rad (slides: ten times that in m).
  double step(double part);
  int unheld() const;

  ModelPointer model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
  std::vector<int> free_;   // joints
  Eigen::VectorXd way_;     // the last step, by free joint
  double turned_back_ = 0;  // how far the last step went against the one before, of its own length; ≤ 0: not at all
};

}  // namespace primo::robot

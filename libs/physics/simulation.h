// The whole robot in full physics among a scenario's objects, driven towards references by the robot file's torques.
#pragma once

#include <cmath>
#include <string>

#include "physics/contact_log.h"
#include "physics/joint_map.h"
#include "physics/recording.h"
#include "physics/verdict.h"
#include "robot/robot.h"
#include "symbols/snapshot.h"

namespace primo::physics {

/// Where the robot is to be at one time: rad, rad/s, rad/s².
struct Reference {
  Eigen::VectorXd q, velocity, acceleration;
  int step = 0;  ///< of the plan
};

/// Cubic Hermite interpolation of the rows of q with central differences as slopes; at rest at both ends.
Reference reference_at(const Eigen::MatrixXd& q, double dt, double time);
Reference at_rest(const Eigen::VectorXd& q);

/// Arm configurations that move the grasp frame from q straight by `along` (m, in W), its orientation kept, in `parts`
/// parts, slow at both ends: as far as the arm can. Where it cannot, it goes less far, and smoothly: this is the
/// judge's motion, and nothing that a plan should be blamed for (docs/decisions/0203).
Eigen::MatrixXd straight_path(const robot::Robot& robot, Eigen::VectorXd q, const Eigen::Vector3d& along, int parts);

/// How long a row of such a path takes, s: `shortest`, or longer, up to four times that, where an arm joint would be
/// faster than its max_speed.
double row_seconds(const robot::Robot& robot, const Eigen::MatrixXd& path, double shortest);

class Simulation {
 public:
  /// `object`: what displacements and grips are measured of. What happens is also written into `recording`, where there
  /// is one.
  Simulation(const robot::Robot& robot, const JudgeRequest& request, Model model, const std::string& object,
             Recording* recording = nullptr);

  int steps_in(double seconds) const { return static_cast<int>(std::lround(seconds / m_->opt.timestep)); }
  double timestep() const { return m_->opt.timestep; }

  enum class Fingers { follow, close, hold };

  /// One time step towards a reference. False when the simulation diverged.
  bool step(const Reference& reference, Fingers fingers, bool gains);

  /// Fingers::hold presses from now on with the closing torque where the fingers are.
  void freeze_fingers(const Eigen::VectorXd& planned);

  /// Fingers::hold moves towards these from now on, rad.
  void set_finger_targets(const Eigen::VectorXd& targets) { targets_ = targets; }
  const Eigen::VectorXd& finger_targets() const { return targets_; }

  /// Holds the object where it is while the fingers close on it, or lets it go.
  void pin(bool pinned);
  /// Whether nothing moves but by less than 2 mm/s or mrad/s.
  bool still() const;
  /// Several contacts between two convex bodies: what stacked cylinders need to come to rest.
  void use_multiccd() { m_->opt.enableflags |= mjENBL_MULTICCD; }

  void update() { mj_forward(m_, d_); }
  const Model& model() const { return model_; }
  const mjData* data() const { return d_; }
  const JointMap& joints() const { return joints_; }
  Pose X_PO() const { return body_pose(d_, palm_).inverse(Eigen::Isometry) * body_pose(d_, object_body_); }
  double object_height() const { return d_->xpos[3 * object_body_ + 2]; }
  Grip grip() const { return joints_.grip(m_, d_, object_geom_); }
  /// What holds an object in this hand, in words.
  const char* holders() const { return joints_.holders(); }
  double tracking_error(const Reference& r) const;
  const Eigen::VectorXd& q() const { return q_; }
  int steps() const { return steps_; }
  const ContactLog& contacts() const { return contacts_; }

  /// The scenario's bodies where they are now, nothing in the hand. @pre positions are up to date (update())
  symbols::WorldSnapshot world() const;

 private:
  void drive_arm(const Reference& r, Fingers fingers, bool gains);
  void keep_frame();

  const robot::Robot& robot_;
  const JudgeRequest& request_;
  Recording* recording_;
  Model model_;
  Data data_;
  mjModel* m_;
  mjData* d_;
  JointMap joints_;
  int object_body_, object_geom_, palm_ = 0;
  Pin pin_;  // of the object
  Eigen::VectorXd q_, velocity_, targets_;
  ContactLog contacts_;
  int steps_ = 0;
};

}  // namespace primo::physics

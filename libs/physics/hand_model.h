// The hand alone in physics: everything that the last arm joint carries, fixed in its own frame, with one free object.
//
// Simulating in the hand's frame P (the body of the last arm joint) keeps fourteen degrees of freedom instead of the
// whole robot's; gravity and the motion of P enter as forces (see apply_frame_forces).
#pragma once

#include <string>
#include <vector>

#include "physics/jiggle.h"
#include "physics/model.h"
#include "robot/robot.h"

namespace primo::physics {

/// Name of the object's body, joint and geom in a hand model.
inline constexpr const char* kHandObject = "primo:object";

/// The robot alone, compiled as its file has it.
Result<Model> robot_model(const robot::Robot& robot);

/// X_WP at q: of the body that the last arm joint moves.
Pose palm_pose(const robot::Robot& robot, const Eigen::VectorXd& q);

/// The part of `model` that the robot's last arm joint carries, as MJCF. Error: a geom or joint of it that is not a
/// primitive shape, hinge or slide.
struct HandMjcf {
  std::string bodies, equalities, tendons;  ///< tendons: a section of its own, or nothing
};
Result<HandMjcf> hand_mjcf(const robot::Robot& robot, const mjModel* model);

/// The model of the part of `model` that the robot's last arm joint carries, with an object of this shape and mass
/// (kg). No gravity, no actuators. Errors: as hand_mjcf().
Result<Model> hand_model(const robot::Robot& robot, const mjModel* model, const Shape& object, double mass,
                         double timestep);

/// Writes xfrc_applied of every body: gravity (m/s², in N) and the inertial forces of P moving as `shaker` says, where
/// a = shaker.acceleration is that of the point c fixed in P at `centre` (m, in P). Exact for rigid bodies: a body of
/// mass m at r with velocity v and spin w in P gets
///   f = m (Rᵀg − a − α×(r−c) − ω×(ω×(r−c)) − 2 ω×v),   τ = −(Iα + I(ω×w) + ω×Iω + ω×Iw + w×Iω).
/// @pre positions and velocities of `data` are up to date (mj_step1).
void apply_frame_forces(const mjModel* model, mjData* data, const ShakerState& shaker, const Eigen::Vector3d& centre,
                        const Eigen::Vector3d& gravity_N);

}  // namespace primo::physics

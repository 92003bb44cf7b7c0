// MuJoCo models of a scene and a robot, owned. The world frame is the scenario's: z up, origin at the robot base's
// centre on the floor.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "core/pose.h"
#include "core/result.h"
#include "robot/mjcf.h"
#include "robot/robot.h"
#include "scene/scenario.h"

namespace primo::physics {

struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// An owned mjModel. Const use is safe from any number of threads.
class Model {
 public:
  Model() = default;
  explicit Model(mjModel* model) : model_(model) {}
  const mjModel* get() const { return model_.get(); }
  mjModel* get() { return model_.get(); }
  const mjModel* operator->() const { return model_.get(); }
  mjModel* operator->() { return model_.get(); }

  /// The id of a named body, geom or joint; −1 when there is none.
  int body(const std::string& name) const { return mj_name2id(model_.get(), mjOBJ_BODY, name.c_str()); }
  int geom(const std::string& name) const { return mj_name2id(model_.get(), mjOBJ_GEOM, name.c_str()); }
  int joint(const std::string& name) const { return mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str()); }

  Model copy() const { return Model(mj_copyModel(nullptr, model_.get())); }

 private:
  robot::ModelPointer model_;
};

/// An owned mjData of one model, which must outlive it. For one thread at a time.
class Data {
 public:
  Data() = default;
  explicit Data(const Model& model) : data_(mj_makeData(model.get())) {}
  const mjData* get() const { return data_.get(); }
  mjData* get() { return data_.get(); }
  const mjData* operator->() const { return data_.get(); }
  mjData* operator->() { return data_.get(); }

 private:
  std::unique_ptr<mjData, DataDeleter> data_;
};

/// Contact bits. Robot against scene and scene against scene collide; robot against robot does not.
inline constexpr int kRobotContype = 1, kRobotConaffinity = 2;
inline constexpr int kSceneContype = 3, kSceneConaffinity = 3;
/// Geom groups: what rays and pictures filter by.
/// A robot's colliding shapes are hidden where its body has others for the eye.
inline constexpr int kFixtureGroup = 0, kObjectGroup = 1, kRobotGroup = 2, kHiddenGroup = 3;

struct AssembleOptions {
  double timestep = 0.002;  ///< s
  bool moves = true;        ///< false: only its geometry is asked for, so no room is made for contacts
  std::string extra;        ///< MJCF sections put after the scene, e.g. <asset> and <visual> of a picture
};

/// The scene as a model: geoms "floor" and the table's name on the world body (group 0), and for each object a body of
/// its name with a free joint of its name and a geom "object:NAME" (group 1), at the scenario's poses in qpos0; the
/// robot (group 2) as its file has it, or none when `robot` is null. Errors: what MuJoCo refuses, with the robot's file
/// name; names taken twice.
Result<Model> assemble(const robot::Robot* robot, const scene::Scenario& scenario, const AssembleOptions& options = {});

/// Makes the robot in `model` what primo plans with, whatever its file's contact bits and groups are: meshes that
/// collide are covered by primitive shapes, the robot's shapes collide with the scene and not with each other, and
/// groups say what is drawn. Error: a mesh that cannot be covered.
Status prepare_robot(const robot::Robot& robot, Model& model);

/// Compiles MJCF text. Files it includes are looked up beside `directory`. `what` names it in errors. Safe from any
/// thread.
Result<Model> compile(const std::string& mjcf, const std::filesystem::path& directory, const std::string& what);

/// Solver options that hold a grasp, and contact parameters of scene geoms, as MJCF text.
std::string solver_mjcf(double timestep);
/// margin: m, the distance at which forces begin.
std::string contact_attributes(double margin = 0);
/// `text` safe inside an MJCF attribute.
std::string xml_escape(const std::string& text);
/// Numbers as MJCF has them: shortest form that reads back to the same double, separated by spaces.
std::string numbers(const double* values, int count);
std::string numbers(const Eigen::VectorXd& values);
/// type="…" size="…" of a geom.
std::string shape_attributes(const Shape& shape);
/// pos="…" quat="…".
std::string pose_attributes(const Pose& X);

/// X_WB of a body after mj_kinematics.
Pose body_pose(const mjData* data, int body);
/// Puts a free joint at X_WB, at rest. Other joints keep what they have.
void set_free_joint(const mjModel* model, mjData* data, int joint, const Pose& X_WB);
/// Holds a free body where it is, as heavy as a building, so that the solver treats it as fixed; or lets it be as it
/// was. (A constraint that holds it would yield, and a body moved by hand has no velocity in the solver's eyes.) A body
/// whose inertia is the same in all poses takes it from dof_M0 and not from its armature, so both are set.
class Pin {
 public:
  Pin() = default;
  /// @pre the joint is free, and not held in `model`.
  Pin(const Model& model, int joint);
  /// At rest from now on.
  void hold(mjModel* model, mjData* data) const;
  void release(mjModel* model, mjData* data) const;

 private:
  int dof_ = -1;
  std::array<mjtNum, 6> inertia_{}, armature_{};
};

/// Whether MuJoCo has seen bad numbers or full buffers since the last reset: the simulation is not to be trusted then.
bool diverged(const mjData* data);

}  // namespace primo::physics

// MJCF models: read from files as one document, and compiled by MuJoCo.
#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <string>

#include "core/pose.h"
#include "core/result.h"

namespace primo::robot {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using ModelPointer = std::unique_ptr<mjModel, ModelDeleter>;

/// The name of an element of a model, or "#" and its id.
std::string name_of(const mjModel& model, mjtObj type, int id);

/// What a robot's MJCF file says of bodies, joints and their couplings: the sections of its <mujoco> element as text,
/// included files put in, bodies and joints without a name given one. Left out is what primo sets itself or does not
/// use: options, sizes, keyframes, actuators, sensors, contact pairs and excludes, statistics and the look of the
/// scene, lights and cameras too. Error (Code::config): a file that cannot be read or is not MJCF; a feature that
/// MuJoCo 2.2 does not read, with its file and line (see mjcf_features.h). Unless X_WM is the identity, all that the
/// model has in its world is put into a fixed body there, "primo:base": the model's origin then stands at X_WM.
Result<std::string> read_mjcf(const std::filesystem::path& path, const Pose& X_WM = Pose::Identity());

/// Compiles MJCF text. Files it names are looked up beside `directory`. `what` names it in errors. Safe from any
/// thread.
Result<ModelPointer> compile_mjcf(const std::string& mjcf, const std::filesystem::path& directory,
                                  const std::string& what);

/// Compiles a robot as read_mjcf has it, its colliding meshes covered (see mesh_cover.h). When MuJoCo refuses it, the
/// error has the file's own line.
Result<ModelPointer> compile_robot(const std::string& sections, const std::filesystem::path& path);

}  // namespace primo::robot

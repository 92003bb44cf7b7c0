// One hash over all files that make a robot what it is.
#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"

namespace primo::robot {

/// Of the robot file, the model as read_mjcf() has it (included files put in, comments and unused sections left out)
/// and the files of its assets, meshes above all: hexadecimal digits that change when any of them does, wherever they
/// lie. Error (Code::config): a file that cannot be read.
Result<std::string> files_digest(const std::filesystem::path& robot_file, const std::filesystem::path& mjcf);

}  // namespace primo::robot

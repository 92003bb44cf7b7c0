// What MuJoCo says on refusing a model, with the place it means.
#pragma once

#include <filesystem>
#include <string>

namespace primo::robot {

/// MuJoCo's `message` on refusing the model in file `path`, as one sentence that begins with the place. An element or
/// an attribute that MuJoCo does not know is named with its file and line. MuJoCo itself tells neither for included
/// files, so those are searched. @pre the files have been read before: what cannot be read now is passed over.
std::string refusal(const std::filesystem::path& path, const std::string& message);

}  // namespace primo::robot

// An off-screen software OpenGL context and MuJoCo's renderer in it. Inside of picture.cpp.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "physics/model.h"

namespace primo::physics {

struct Image {
  int width = 0, height = 0;
  std::vector<unsigned char> rgb;  ///< rows from the top, 3 bytes a pixel
};

/// Draws `scene` of `model` (its off-screen buffer must be width × height or larger). Serialised over threads: OpenGL's
/// context is the process's.
Result<Image> draw(const Model& model, mjvScene& scene, int width, int height);

/// Each pixel the mean of factor × factor pixels.
Image shrink(const Image& image, int factor);

/// The image as a PNG file's bytes.
Result<std::string> png_bytes(const Image& image);

}  // namespace primo::physics

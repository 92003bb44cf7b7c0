#include "physics/renderer.h"

#include <GL/osmesa.h>
#include <png.h>

#include <algorithm>
#include <mutex>

namespace primo::physics {
namespace {

struct ContextDeleter {
  void operator()(osmesa_context* context) const { OSMesaDestroyContext(context); }
};

}  // namespace

Result<Image> draw(const Model& model, mjvScene& scene, int width, int height) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  // MuJoCo draws into its own buffer; the context only needs some buffer to be current with.
  std::vector<unsigned char> buffer(4 * 64 * 64);
  const std::unique_ptr<osmesa_context, ContextDeleter> context(OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 8, nullptr));
  if (!context || !OSMesaMakeCurrent(context.get(), buffer.data(), GL_UNSIGNED_BYTE, 64, 64)) {
    return Error{Code::unavailable,
                 "no software renderer: OSMesa gives no OpenGL context; Debian's libosmesa6 is needed"};
  }
  mjrContext renderer;
  mjr_defaultContext(&renderer);
  mjr_makeContext(model.get(), &renderer, mjFONTSCALE_100);
  mjr_setBuffer(mjFB_OFFSCREEN, &renderer);
  Image image{width, height, std::vector<unsigned char>(static_cast<std::size_t>(3) * width * height)};
  std::vector<unsigned char> upside_down(image.rgb.size());
  const bool ready =
      renderer.currentBuffer == mjFB_OFFSCREEN && renderer.offWidth >= width && renderer.offHeight >= height;
  if (ready) {
    const mjrRect viewport{0, 0, width, height};
    mjr_render(viewport, &scene, &renderer);
    mjr_readPixels(upside_down.data(), nullptr, viewport, &renderer);
  }
  mjr_freeContext(&renderer);
  OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  if (!ready) return Error{Code::unavailable, "the software renderer has no off-screen buffer of the picture's size"};
  const std::size_t row = static_cast<std::size_t>(3) * width;
  for (int y = 0; y < height; ++y) {
    std::copy_n(upside_down.begin() + static_cast<std::ptrdiff_t>((height - 1 - y) * row), row,
                image.rgb.begin() + static_cast<std::ptrdiff_t>(y * row));
  }
  return image;
}

Image shrink(const Image& image, int factor) {
  Image small{image.width / factor, image.height / factor, {}};
  small.rgb.resize(static_cast<std::size_t>(3) * small.width * small.height);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int dy = 0; dy < factor; ++dy) {
          for (int dx = 0; dx < factor; ++dx) {
            sum +=
                image.rgb[static_cast<std::size_t>(3) * ((y * factor + dy) * image.width + x * factor + dx) + channel];
          }
        }
        small.rgb[static_cast<std::size_t>(3) * (y * small.width + x) + channel] =
            static_cast<unsigned char>((sum + factor * factor / 2) / (factor * factor));
      }
    }
  }
  return small;
}

Result<std::string> png_bytes(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr)) {
    return Error{Code::failed, std::string("cannot encode a PNG: ") + png.message};
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace primo::physics

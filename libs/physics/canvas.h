// One picture in the making: the model posed, its scene filled. Inside of picture.cpp and movie.cpp.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "physics/picture.h"
#include "physics/renderer.h"

namespace primo::physics {

using Colour = std::array<float, 4>;
inline constexpr Colour kLine = {0.90F, 0.36F, 0.10F, 1}, kOtherLine = {0.15F, 0.35F, 0.75F, 1};

class Canvas {
 public:
  /// How finely a picture is drawn before it is made smaller.
  struct Quality {
    int supersampling = 2;
    int shadows = 4096;  ///< pixels of the shadow map's side
    bool reflections = true;
  };

  /// @pre `robot` (or null) outlives the canvas. Errors as of render_png().
  static Result<Canvas> create(const robot::Robot* robot, const scene::Scenario& scenario,
                               const PictureOptions& options, Quality quality);
  static Result<Canvas> create(const robot::Robot* robot, const scene::Scenario& scenario,
                               const PictureOptions& options) {
    return create(robot, scenario, options, Quality());
  }

  void pose_robot(const Eigen::VectorXd& q);
  /// Of the object with this name.
  void pose_object(const std::string& name, const Pose& X_WO);

  /// Fills the scene with the model as it is posed; what was drawn before is gone.
  void draw_all();
  /// The robot's moving shapes at q, transparent, over what is drawn.
  /// The object `with`, where there is one of that name, is drawn with it where it is posed.
  void draw_ghost(const Eigen::VectorXd& q, float alpha, const std::string& with = {});
  void draw_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Colour& colour = kLine);
  void draw_dot(const Eigen::Vector3d& p, double radius, const Colour& colour = kLine);
  /// The path of the grasp centre over the rows of q, its ends as dots.
  void draw_path(const Eigen::MatrixXd& q, bool dashed, const Colour& colour = kLine);

  Result<Image> image(const View& view);

 private:
  struct Scene;
  struct SceneDeleter {
    void operator()(Scene* scene) const;
  };
  Canvas(Model model, const robot::Robot* robot, const PictureOptions& options, Quality quality);
  mjvGeom* add(int type, const mjtNum* size, const mjtNum* pos, const mjtNum* mat, const float* rgba);

  Model model_;
  Data data_;
  std::unique_ptr<Scene, SceneDeleter> scene_;
  const robot::Robot* robot_;
  mjvOption option_;
  int width_, height_;
  Quality quality_;
};

}  // namespace primo::physics

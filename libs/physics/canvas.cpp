#include "physics/canvas.h"

#include <algorithm>
#include <cmath>

#include "physics/joint_map.h"

namespace primo::physics {

/// MuJoCo's abstract scene, owned.
struct Canvas::Scene {
  Scene(const Model& model, int most) {
    mjv_defaultScene(&scene);
    mjv_makeScene(model.get(), &scene, most);
  }
  ~Scene() { mjv_freeScene(&scene); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  mjvScene scene;
};
void Canvas::SceneDeleter::operator()(Scene* scene) const { delete scene; }

namespace {

constexpr Colour kTarget = {0.46F, 0.20F, 0.62F, 1}, kOther = {0.30F, 0.62F, 0.32F, 1},
                 kTable = {0.72F, 0.60F, 0.46F, 1};

/// Lights, sky, floor and legs of the table: for the eye only.
std::string decoration(const scene::Scenario& scenario, int width, int height, int shadows) {
  std::string text =
      "  <visual>\n    <global offwidth=\"" + std::to_string(width) + "\" offheight=\"" + std::to_string(height) +
      "\"/>\n    <quality shadowsize=\"" + std::to_string(shadows) +
      "\" offsamples=\"0\"/>\n"
      "    <headlight ambient=\"0.34 0.34 0.36\" diffuse=\"0.28 0.28 0.28\" specular=\"0.1 0.1 0.1\"/>\n"
      "    <map znear=\"0.02\" zfar=\"40\" shadowclip=\"1.6\"/>\n  </visual>\n"
      "  <statistic center=\"0.6 0 0.6\" extent=\"1.5\"/>\n  <asset>\n"
      "    <texture type=\"skybox\" builtin=\"gradient\" rgb1=\"0.93 0.95 0.98\" rgb2=\"0.76 0.81 0.88\" width=\"64\" "
      "height=\"384\"/>\n"
      "    <texture name=\"primo:tiles\" type=\"2d\" builtin=\"checker\" rgb1=\"0.83 0.84 0.86\" rgb2=\"0.78 0.79 "
      "0.82\" "
      "width=\"256\" height=\"256\"/>\n"
      "    <material name=\"primo:floor\" texture=\"primo:tiles\" texrepeat=\"3 3\" texuniform=\"true\" "
      "specular=\"0.05\" "
      "reflectance=\"0.06\"/>\n  </asset>\n  <worldbody>\n"
      "    <light directional=\"true\" pos=\"1.2 -1.2 3\" dir=\"-0.35 0.4 -1\" diffuse=\"0.55 0.54 0.52\" "
      "specular=\"0.25 0.25 0.25\" castshadow=\"true\"/>\n"
      "    <light directional=\"true\" pos=\"-1 2 2\" dir=\"0.6 -0.7 -0.5\" diffuse=\"0.14 0.15 0.18\" specular=\"0 0 "
      "0\" "
      "castshadow=\"false\"/>\n";
  const auto& table = scenario.table;
  const double height_under = table.top_centre.z() - table.thickness;
  if (height_under > 0.05) {
    for (const double sx : {-1.0, 1.0}) {
      for (const double sy : {-1.0, 1.0}) {
        const Eigen::Vector3d foot(table.top_centre.x() + sx * (table.size.x() / 2 - 0.03),
                                   table.top_centre.y() + sy * (table.size.y() / 2 - 0.03), height_under / 2);
        text += "    <geom" + shape_attributes({ShapeType::box, {0.02, 0.02, height_under / 2}}) +
                pose_attributes(pose(foot)) +
                " contype=\"0\" conaffinity=\"0\" group=\"0\" rgba=\"0.45 0.37 0.3 1\"/>\n";
      }
    }
  }
  return text + "  </worldbody>\n";
}

void paint(Model& model, const scene::Scenario& scenario) {
  const auto colour = [&](int geom, const Colour& rgba) {
    if (geom >= 0) std::copy(rgba.begin(), rgba.end(), model->geom_rgba + 4 * geom);
  };
  colour(model.geom(scenario.table.name), kTable);
  for (const auto& object : scenario.objects) {
    const bool target = scenario.action.size() > 1 && scenario.action[1] == object.name;
    colour(model.geom("object:" + object.name), target ? kTarget : kOther);
  }
  if (const int floor = model.geom("floor"); floor >= 0) {
    model->geom_matid[floor] = mj_name2id(model.get(), mjOBJ_MATERIAL, "primo:floor");
    colour(floor, {1, 1, 1, 1});
  }
}

void aim(mjvScene& scene, const View& view) {
  const Eigen::Vector3d forward = (view.look_at - view.position).normalized();
  Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
  if (right.norm() < 1e-6) right = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d up = right.normalized().cross(forward);
  const double near = 0.02, top = near * std::tan(view.fov_y / 2);
  for (auto& camera : scene.camera) {
    for (int i = 0; i < 3; ++i) {
      camera.pos[i] = static_cast<float>(view.position[i]);
      camera.forward[i] = static_cast<float>(forward[i]);
      camera.up[i] = static_cast<float>(up[i]);
    }
    camera.frustum_center = 0;
    camera.frustum_bottom = static_cast<float>(-top);
    camera.frustum_top = static_cast<float>(top);
    camera.frustum_near = static_cast<float>(near);
    camera.frustum_far = 60;
  }
}

}  // namespace

Canvas::Canvas(Model model, const robot::Robot* robot, const PictureOptions& options, Quality quality)
    : model_(std::move(model)),
      data_(model_),
      scene_(new Scene(model_, 4000)),
      robot_(robot),
      width_(options.width),
      height_(options.height),
      quality_(quality) {
  mjv_defaultOption(&option_);
  mj_forward(model_.get(), data_.get());
}

Result<Canvas> Canvas::create(const robot::Robot* robot, const scene::Scenario& scenario, const PictureOptions& options,
                              Quality quality) {
  for (const int side : {options.width, options.height}) {
    if (side < 16 || side > 2048) {
      return Error{Code::usage, "a picture is 16 … 2048 pixels wide and high, not " + std::to_string(options.width) +
                                    " × " + std::to_string(options.height)};
    }
  }
  AssembleOptions assembly;
  const int finer = quality.supersampling;
  assembly.extra = decoration(scenario, options.width * finer, options.height * finer, quality.shadows);
  PRIMO_ASSIGN(Model model, assemble(robot, scenario, assembly));
  paint(model, scenario);
  return Canvas(std::move(model), robot, options, quality);
}

void Canvas::pose_robot(const Eigen::VectorXd& q) {
  if (robot_) JointMap(*robot_, model_.get()).set(data_.get(), q);
  mj_forward(model_.get(), data_.get());
}

void Canvas::pose_object(const std::string& name, const Pose& X_WO) {
  set_free_joint(model_.get(), data_.get(), model_.joint(name), X_WO);
  mj_forward(model_.get(), data_.get());
}

void Canvas::draw_all() {
  mjvPerturb perturb;
  mjv_defaultPerturb(&perturb);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  mjv_updateScene(model_.get(), data_.get(), &option_, &perturb, &camera, mjCAT_ALL, &scene_->scene);
}

void Canvas::draw_ghost(const Eigen::VectorXd& q, float alpha, const std::string& with) {
  pose_robot(q);
  const int object = with.empty() ? -1 : model_.body(with);
  for (int g = 0; g < model_->ngeom; ++g) {
    const int body = model_->geom_bodyid[g];
    const bool of_robot = model_->geom_group[g] == kRobotGroup && model_->body_weldid[body] != 0;
    if (!of_robot && body != object) continue;
    Colour rgba{};
    std::copy_n(model_->geom_rgba + 4 * g, 4, rgba.begin());
    for (std::size_t channel = 0; channel < 3; ++channel)
      rgba[channel] = 0.45F * rgba[channel] + 0.55F * std::array{0.35F, 0.50F, 0.75F}[channel];
    rgba[3] = alpha;
    add(model_->geom_type[g], model_->geom_size + 3 * g, data_->geom_xpos + 3 * g, data_->geom_xmat + 9 * g,
        rgba.data());
  }
}

void Canvas::draw_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Colour& colour) {
  mjvGeom* geom = add(mjGEOM_CAPSULE, nullptr, nullptr, nullptr, colour.data());
  if (geom) mjv_makeConnector(geom, mjGEOM_CAPSULE, 0.006, a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
}

void Canvas::draw_dot(const Eigen::Vector3d& p, double radius, const Colour& colour) {
  const std::array<mjtNum, 3> size = {radius, radius, radius};
  add(mjGEOM_SPHERE, size.data(), p.data(), nullptr, colour.data());
}

void Canvas::draw_path(const Eigen::MatrixXd& q, bool dashed, const Colour& colour) {
  const Eigen::Index last = q.rows() - 1;
  Eigen::Vector3d before(0, 0, 0);
  for (Eigen::Index t = 0; t <= last; ++t) {
    const Eigen::Vector3d p = robot_->pose(robot_->forward(q.row(t).transpose()), robot_->grasp_frame()).translation();
    if (t > 0 && (!dashed || (t / 2) % 2 == 0) && (p - before).norm() > 1e-4) draw_line(before, p, colour);
    if (t == 0 || t == last) draw_dot(p, 0.011, colour);
    before = p;
  }
}

Result<Image> Canvas::image(const View& view) {
  auto& scene = scene_->scene;
  aim(scene, view);
  scene.flags[mjRND_SHADOW] = 1;
  scene.flags[mjRND_REFLECTION] = quality_.reflections ? 1 : 0;
  scene.flags[mjRND_SKYBOX] = 1;
  const int finer = quality_.supersampling;
  PRIMO_ASSIGN(Image large, draw(model_, scene, width_ * finer, height_ * finer));
  return finer == 1 ? std::move(large) : shrink(large, finer);
}

mjvGeom* Canvas::add(int type, const mjtNum* size, const mjtNum* pos, const mjtNum* mat, const float* rgba) {
  auto& scene = scene_->scene;
  if (scene.ngeom >= scene.maxgeom) return nullptr;
  mjvGeom* geom = scene.geoms + scene.ngeom++;
  mjv_initGeom(geom, type, size, pos, mat, rgba);
  geom->category = mjCAT_DECOR;
  geom->specular = 0.3F;
  return geom;
}

}  // namespace primo::physics

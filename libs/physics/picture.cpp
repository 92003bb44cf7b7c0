#include "physics/picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/files.h"
#include "physics/joint_map.h"
#include "physics/renderer.h"

namespace primo::physics {
namespace {

constexpr int kSupersampling = 2;
constexpr std::array<float, 4> kTarget = {0.46F, 0.20F, 0.62F, 1}, kOther = {0.30F, 0.62F, 0.32F, 1},
                               kTable = {0.72F, 0.60F, 0.46F, 1}, kLine = {0.90F, 0.36F, 0.10F, 1};

/// Lights, sky, floor and legs of the table: for the eye only.
std::string decoration(const scene::Scenario& scenario, int width, int height) {
  std::string text =
      "  <visual>\n    <global offwidth=\"" + std::to_string(width) + "\" offheight=\"" + std::to_string(height) +
      "\"/>\n    <quality shadowsize=\"4096\" offsamples=\"0\"/>\n"
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

/// MuJoCo's abstract scene, owned.
struct Scene {
  Scene(const Model& model, int most) {
    mjv_defaultScene(&scene);
    mjv_makeScene(model.get(), &scene, most);
  }
  ~Scene() { mjv_freeScene(&scene); }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  mjvScene scene;
};

void paint(Model& model, const scene::Scenario& scenario) {
  const auto colour = [&](int geom, const std::array<float, 4>& rgba) {
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

/// One picture in the making: the model posed, its scene filled.
class Canvas {
 public:
  static Result<Canvas> create(const robot::Robot* robot, const scene::Scenario& scenario,
                               const PictureOptions& options) {
    for (const int side : {options.width, options.height}) {
      if (side < 16 || side > 2048) {
        return Error{Code::usage, "a picture is 16 … 2048 pixels wide and high, not " + std::to_string(options.width) +
                                      " × " + std::to_string(options.height)};
      }
    }
    AssembleOptions assembly;
    assembly.extra = decoration(scenario, options.width * kSupersampling, options.height * kSupersampling);
    PRIMO_ASSIGN(Model model, assemble(robot, scenario, assembly));
    paint(model, scenario);
    return Canvas(std::move(model), robot);
  }

  void pose_robot(const Eigen::VectorXd& q) {
    if (robot_) JointMap(*robot_, model_.get()).set(data_.get(), q);
    mj_forward(model_.get(), data_.get());
  }

  void draw_all() {
    mjvPerturb perturb;
    mjv_defaultPerturb(&perturb);
    mjvCamera camera;
    mjv_defaultCamera(&camera);
    mjv_updateScene(model_.get(), data_.get(), &option_, &perturb, &camera, mjCAT_ALL, &scene_->scene);
  }

  /// The robot's moving shapes once more, transparent.
  void draw_ghost(const Eigen::VectorXd& q, float alpha) {
    pose_robot(q);
    for (int g = 0; g < model_->ngeom; ++g) {
      if (model_->geom_group[g] != kRobotGroup || model_->body_weldid[model_->geom_bodyid[g]] == 0) continue;
      std::array<float, 4> rgba{};
      std::copy_n(model_->geom_rgba + 4 * g, 4, rgba.begin());
      for (int channel = 0; channel < 3; ++channel)
        rgba[channel] = 0.45F * rgba[channel] + 0.55F * std::array{0.35F, 0.50F, 0.75F}[channel];
      rgba[3] = alpha;
      mjvGeom* ghost = add(model_->geom_type[g], model_->geom_size + 3 * g, data_->geom_xpos + 3 * g,
                           data_->geom_xmat + 9 * g, rgba.data());
      // The renderer numbers a mesh and its hull in turns.
      if (ghost && model_->geom_type[g] == mjGEOM_MESH) ghost->dataid = 2 * model_->geom_dataid[g];
    }
  }

  void draw_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    mjvGeom* geom = add(mjGEOM_CAPSULE, nullptr, nullptr, nullptr, kLine.data());
    if (geom) mjv_makeConnector(geom, mjGEOM_CAPSULE, 0.006, a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
  }

  void draw_dot(const Eigen::Vector3d& p, double radius) {
    const std::array<mjtNum, 3> size = {radius, radius, radius};
    add(mjGEOM_SPHERE, size.data(), p.data(), nullptr, kLine.data());
  }

  Status write(const std::filesystem::path& path, const View& view, const PictureOptions& options) {
    auto& scene = scene_->scene;
    aim(scene, view);
    scene.flags[mjRND_SHADOW] = 1;
    scene.flags[mjRND_REFLECTION] = 1;
    scene.flags[mjRND_SKYBOX] = 1;
    PRIMO_ASSIGN(const Image large,
                 draw(model_, scene, options.width * kSupersampling, options.height * kSupersampling));
    PRIMO_ASSIGN(const std::string bytes, png_bytes(shrink(large, kSupersampling)));
    return write_file(path, bytes);
  }

 private:
  Canvas(Model model, const robot::Robot* robot)
      : model_(std::move(model)), data_(model_), scene_(std::make_unique<Scene>(model_, 4000)), robot_(robot) {
    mjv_defaultOption(&option_);
    mj_forward(model_.get(), data_.get());
  }

  mjvGeom* add(int type, const mjtNum* size, const mjtNum* pos, const mjtNum* mat, const float* rgba) {
    auto& scene = scene_->scene;
    if (scene.ngeom >= scene.maxgeom) return nullptr;
    mjvGeom* geom = scene.geoms + scene.ngeom++;
    mjv_initGeom(geom, type, size, pos, mat, rgba);
    geom->category = mjCAT_DECOR;
    geom->specular = 0.3F;
    return geom;
  }

  Model model_;
  Data data_;
  std::unique_ptr<Scene> scene_;
  const robot::Robot* robot_;
  mjvOption option_;
};

Status check_motion(const robot::Robot& robot, Eigen::Index columns, bool finite) {
  if (columns != robot.joints() || !finite) {
    return Error{Code::data, "a picture of robot " + robot.name() + " needs " + std::to_string(robot.joints()) +
                                 " finite joint angles, not " + std::to_string(columns)};
  }
  return success();
}

Eigen::VectorXd shown(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q,
                      bool close_hand) {
  const scene::Object* object = scenario.action.size() > 1 ? scenario.object(scenario.action[1]) : nullptr;
  return close_hand && object ? close_onto(robot, q, object->shape(), object->X_WO()) : q;
}

}  // namespace

View overview(const scene::Scenario& scenario) {
  // Robot at the origin, table in front of it: look from the table's far right at the middle between them.
  const Eigen::Vector3d table = scenario.table.top_centre;
  View view;
  view.look_at = Eigen::Vector3d(0.55 * table.x(), 0.6 * table.y() + 0.08, table.z() + 0.17);
  view.position = view.look_at + Eigen::Vector3d(1.55, -1.25, 0.85);
  view.fov_y = 0.72;
  return view;
}

View table_view(const scene::Scenario& scenario) {
  View view;
  view.look_at = scenario.table.top_centre;
  view.position = view.look_at + 1.35 * scenario.table.size.norm() * Eigen::Vector3d(0.62, -0.62, 0.55);
  view.fov_y = 0.62;
  return view;
}

View close_up(const robot::Robot& robot, const scene::Scenario& scenario, const Eigen::VectorXd& q) {
  const Pose X_WG = robot.pose(robot.forward(q), robot.grasp_frame());
  const scene::Object* object = scenario.action.size() > 1 ? scenario.object(scenario.action[1]) : nullptr;
  View view;
  view.look_at =
      object ? Eigen::Vector3d(0.6 * object->position + 0.4 * X_WG.translation()) : Eigen::Vector3d(X_WG.translation());
  // From the side of the hand, a little ahead of it and above, so that thumb and fingers are both seen.
  Eigen::Vector3d approach = X_WG.linear().col(2), side = approach.cross(Eigen::Vector3d::UnitZ());
  if (side.norm() < 0.1) side = Eigen::Vector3d(0.6, -0.8, 0);
  side.normalize();
  if (side.y() > 0) side = -side;
  approach.z() = 0;
  view.position = view.look_at + 0.50 * side + 0.18 * approach + Eigen::Vector3d(0, 0, 0.36);
  view.fov_y = 0.62;
  return view;
}

Status render_png(const std::filesystem::path& path, const robot::Robot* robot, const scene::Scenario& scenario,
                  const Eigen::VectorXd& q, const PictureOptions& options) {
  if (robot) PRIMO_TRY(check_motion(*robot, q.size(), q.allFinite()));
  auto canvas = Canvas::create(robot, scenario, options);
  if (!canvas.ok()) return canvas.error();
  if (robot) canvas->pose_robot(shown(*robot, scenario, q, options.close_hand));
  canvas->draw_all();
  return canvas->write(path, options.view.value_or(robot ? overview(scenario) : table_view(scenario)), options);
}

Status render_motion_png(const std::filesystem::path& path, const robot::Robot& robot, const scene::Scenario& scenario,
                         const Eigen::MatrixXd& q, const MotionPictureOptions& options) {
  if (q.rows() < 1) return Error{Code::data, "a motion picture needs at least one row of joint angles"};
  PRIMO_TRY(check_motion(robot, q.cols(), q.allFinite()));
  auto canvas = Canvas::create(&robot, scenario, options.picture);
  if (!canvas.ok()) return canvas.error();
  const Eigen::Index last = q.rows() - 1;
  canvas->pose_robot(shown(robot, scenario, q.row(last).transpose(), options.picture.close_hand));
  canvas->draw_all();
  for (int part = 0; part < 2 && last > 0; ++part) canvas->draw_ghost(q.row(last * part / 2).transpose(), 0.3F);
  Eigen::Vector3d before(0, 0, 0);
  for (Eigen::Index t = 0; t <= last; ++t) {
    const Eigen::Vector3d p = robot.pose(robot.forward(q.row(t).transpose()), robot.grasp_frame()).translation();
    if (t > 0 && (!options.dashed || (t / 2) % 2 == 0) && (p - before).norm() > 1e-4) canvas->draw_line(before, p);
    if (t == 0 || t == last) canvas->draw_dot(p, 0.011);
    before = p;
  }
  return canvas->write(path, options.picture.view.value_or(overview(scenario)), options.picture);
}

}  // namespace primo::physics

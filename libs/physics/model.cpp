#include "physics/model.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

#include "physics/contact_filter.h"
#include "robot/mesh_cover.h"
#include "robot/mjcf.h"

namespace primo::physics {
namespace {

/// Sizes that hold six contacts an object and forty of a three-fingered hand: MuJoCo's automatic ones make every reset
/// slow. The solver's matrices, a row a constraint, have to fit the stack several times.
std::string size_mjcf(const robot::Robot* robot, int objects) {
  const int joints = robot ? static_cast<int>(robot->chain().size()) : 0, more = std::max(0, joints - 15);
  const int loops = robot ? static_cast<int>(robot->loops().size()) : 0;
  const int rows = 400 + 100 * objects + 30 * more + 6 * loops, contacts = 100 + 25 * objects + 10 * more;
  const int stack = std::max(400000 + 120000 * objects, 8 * rows * (joints + 6 * objects));
  return "  <size njmax=\"" + std::to_string(rows) + "\" nconmax=\"" + std::to_string(contacts) + "\" nstack=\"" +
         std::to_string(stack) + "\"/>\n";
}

/// What compiling needs: matrices of the degrees of freedom.
std::string still_size_mjcf(const scene::Scenario& scenario) {
  const std::size_t freedoms = 6 * scenario.objects.size();
  return "  <size njmax=\"1\" nconmax=\"1\" nstack=\"" + std::to_string(10000 + 4 * freedoms * freedoms) + "\"/>\n";
}

/// MuJoCo 2.2 finds contacts decimetres deep where two boxes' faces lie in each other, exactly or by micrometres, as
/// those of a box at rest on the table do: one box in eight is thrown away within six seconds. So a box is simulated a
/// tenth of a millimetre smaller, with a margin as wide: forces begin at its true surface, and its faces stay apart.
constexpr double kBoxMargin = 1e-4;  // m

Shape simulated(Shape shape) {
  if (shape.type == ShapeType::box) shape.size.array() -= kBoxMargin;
  return shape;
}

std::string object_mjcf(const scene::Object& object) {
  const std::string name = xml_escape(object.name);
  const double margin = object.type == ShapeType::box ? kBoxMargin : 0;
  return "    <body name=\"" + name + "\"" + pose_attributes(object.X_WO()) + ">\n      <freejoint name=\"" + name +
         "\"/>\n      <geom name=\"object:" + name + "\"" + shape_attributes(simulated(object.shape())) + " mass=\"" +
         numbers(&object.mass, 1) + "\" group=\"1\" rgba=\"0.35 0.65 0.3 1\"" + contact_attributes(margin) +
         "/>\n    </body>\n";
}

std::string table_mjcf(const scene::Table& table) {
  const Shape box{ShapeType::box, {table.size.x() / 2, table.size.y() / 2, table.thickness / 2}};
  const Eigen::Vector3d centre = table.top_centre - Eigen::Vector3d(0, 0, table.thickness / 2);
  return "    <geom name=\"" + xml_escape(table.name) + "\"" + shape_attributes(box) + pose_attributes(pose(centre)) +
         " group=\"0\" rgba=\"0.62 0.5 0.38 1\"" + contact_attributes() + "/>\n";
}

}  // namespace

std::string xml_escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string numbers(const double* values, int count) {
  std::string text;
  std::array<char, 40> buffer{};
  for (int i = 0; i < count; ++i) {
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), values[i]).ptr;
    if (i) text += ' ';
    text.append(buffer.data(), end);
  }
  return text;
}

std::string numbers(const Eigen::VectorXd& values) { return numbers(values.data(), static_cast<int>(values.size())); }

std::string shape_attributes(const Shape& shape) {
  constexpr std::array<const char*, 4> kTypes = {"sphere", "capsule", "cylinder", "box"};
  constexpr std::array<int, 4> kSizes = {1, 2, 2, 3};
  const auto type = static_cast<std::size_t>(shape.type);
  return std::string(" type=\"") + kTypes[type] + "\" size=\"" + numbers(shape.size.data(), kSizes[type]) + "\"";
}

std::string pose_attributes(const Pose& X) {
  const Eigen::Quaterniond q = quaternion(X);
  const std::array<double, 4> wxyz = {q.w(), q.x(), q.y(), q.z()};
  return " pos=\"" + numbers(X.translation()) + "\" quat=\"" + numbers(wxyz.data(), 4) + "\"";
}

std::string contact_attributes(double margin) {
  // All of them: a robot's own defaults must not change the objects.
  return " contype=\"3\" conaffinity=\"3\" condim=\"4\" priority=\"0\" margin=\"" + numbers(&margin, 1) +
         "\" gap=\"0\" solmix=\"1\" "
         "friction=\"0.9 0.01 0.0005\" solref=\"0.01 1\" solimp=\"0.95 "
         "0.99 0.001\"";
}

std::string solver_mjcf(double timestep) {
  return "  <option timestep=\"" + numbers(&timestep, 1) +
         "\" integrator=\"Euler\" solver=\"Newton\" iterations=\"50\" tolerance=\"1e-10\" cone=\"elliptic\" "
         "impratio=\"10\" "
         "noslip_iterations=\"0\"/>\n";
}

Result<Model> compile(const std::string& mjcf, const std::filesystem::path& directory, const std::string& what) {
  use_contact_filter();
  PRIMO_ASSIGN(auto model, robot::compile_mjcf(mjcf, directory, what));
  // MuJoCo changes to sparse matrices at 60 degrees of freedom; scenes of several free bodies gain from 36.
  constexpr int kSparse = 36;
  if (model->nv >= kSparse) model->opt.jacobian = mjJAC_SPARSE;
  return Model(model.release());
}

Result<Model> assemble(const robot::Robot* robot, const scene::Scenario& scenario, const AssembleOptions& options) {
  std::set<std::string> names = {"world", "floor"};
  if (robot) {
    for (const auto& body : robot->bodies()) names.insert(body.name);
    for (const auto& name : robot->joint_names()) names.insert(name);
  }
  if (!names.insert(scenario.table.name).second) {
    return Error{Code::config, "scenario " + scenario.name + ": the table's name \"" + scenario.table.name +
                                   "\" is taken by the world, the floor or the robot; give it another"};
  }
  std::string mjcf = "<mujoco model=\"scene\">\n";
  if (robot) mjcf += robot->mjcf();
  mjcf += solver_mjcf(options.timestep);
  mjcf += options.moves ? size_mjcf(robot, static_cast<int>(scenario.objects.size())) : still_size_mjcf(scenario);
  mjcf +=
      "  <worldbody>\n    <geom name=\"floor\" type=\"plane\" size=\"4 4 0.1\" group=\"0\" rgba=\"0.8 0.82 0.85 1\"" +
      contact_attributes() + "/>\n";
  mjcf += table_mjcf(scenario.table);
  for (const auto& object : scenario.objects) {
    if (!names.insert(object.name).second) {
      return Error{Code::config, "scenario " + scenario.name + ": the name \"" + object.name +
                                     "\" is taken by another object, the table or the robot; give this object another"};
    }
    if (!object.position.allFinite() || !object.rpy.allFinite() || !object.shape().size.allFinite() ||
        !std::isfinite(object.mass)) {
      return Error{Code::data,
                   "scenario " + scenario.name + ": object \"" + object.name + "\" has a number that is not finite"};
    }
    mjcf += object_mjcf(object);
  }
  mjcf += "  </worldbody>\n" + options.extra + "</mujoco>\n";
  const std::filesystem::path directory = robot ? robot->mjcf_path().parent_path() : std::filesystem::path();
  auto model =
      compile(mjcf, directory,
              "scenario " + scenario.name + (robot ? " with robot " + robot->mjcf_path().string() : std::string()));
  if (model.ok() && robot) PRIMO_TRY(prepare_robot(*robot, *model));
  return model;
}

Status prepare_robot(const robot::Robot& robot, Model& model) {
  PRIMO_TRY(robot::cover_meshes(*model.get(), robot.mjcf_path().string()));
  std::vector<char> of_robot(static_cast<std::size_t>(model->nbody), 0), seen = of_robot;
  for (const auto& body : robot.bodies()) {
    if (const int id = model.body(body.name); id >= 0) of_robot[static_cast<std::size_t>(id)] = 1;
  }
  // Of the world's geoms, the robot's come first.
  const int floor = model.geom("floor");
  const auto robots = [&](int g) {
    return of_robot[static_cast<std::size_t>(model->geom_bodyid[g])] &&
           (model->geom_bodyid[g] > 0 || g < floor || floor < 0);
  };
  const auto collides = [&](int g) { return model->geom_contype[g] != 0 || model->geom_conaffinity[g] != 0; };
  for (int g = 0; g < model->ngeom; ++g) {
    if (robots(g) && !collides(g)) seen[static_cast<std::size_t>(model->geom_bodyid[g])] = 1;
  }
  for (int g = 0; g < model->ngeom; ++g) {
    if (!robots(g)) continue;
    model->geom_group[g] =
        collides(g) && seen[static_cast<std::size_t>(model->geom_bodyid[g])] ? kHiddenGroup : kRobotGroup;
    if (!collides(g)) continue;
    model->geom_contype[g] = kRobotContype;
    model->geom_conaffinity[g] = kRobotConaffinity;
  }
  return success();
}

Pose body_pose(const mjData* data, int body) {
  Pose X = Pose::Identity();
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body);
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * body);
  return X;
}

void set_free_joint(const mjModel* model, mjData* data, int joint, const Pose& X_WB) {
  PRIMO_CHECK(joint >= 0 && joint < model->njnt && model->jnt_type[joint] == mjJNT_FREE, "needs a free joint");
  double* qpos = data->qpos + model->jnt_qposadr[joint];
  const Eigen::Quaterniond q = quaternion(X_WB);
  Eigen::Map<Eigen::Vector3d>(qpos, 3) = X_WB.translation();
  qpos[3] = q.w(), qpos[4] = q.x(), qpos[5] = q.y(), qpos[6] = q.z();
  std::fill_n(data->qvel + model->jnt_dofadr[joint], 6, 0.0);
}

Pin::Pin(const Model& model, int joint) : dof_(model->jnt_dofadr[joint]) {
  std::copy_n(model->dof_M0 + dof_, 6, inertia_.begin());
  std::copy_n(model->dof_armature + dof_, 6, armature_.begin());
}

void Pin::hold(mjModel* model, mjData* data) const {
  constexpr mjtNum kBuilding = 1e5;  // kg, kg·m²
  std::fill_n(model->dof_M0 + dof_, 6, kBuilding);
  std::fill_n(model->dof_armature + dof_, 6, kBuilding);
  std::fill_n(data->qvel + dof_, 6, 0.0);
}

void Pin::release(mjModel* model, mjData* data) const {
  std::copy_n(inertia_.begin(), 6, model->dof_M0 + dof_);
  std::copy_n(armature_.begin(), 6, model->dof_armature + dof_);
  std::fill_n(data->qvel + dof_, 6, 0.0);
}

bool diverged(const mjData* data) {
  for (const int warning : {mjWARN_INERTIA, mjWARN_CONTACTFULL, mjWARN_CNSTRFULL, mjWARN_BADQPOS, mjWARN_BADQVEL,
                            mjWARN_BADQACC, mjWARN_BADCTRL}) {
    if (data->warning[warning].number > 0) return true;
  }
  return false;
}

}  // namespace primo::physics

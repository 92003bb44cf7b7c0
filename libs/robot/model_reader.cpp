// Reads a Robot out of its robot file and the compiled MJCF model.
#include <mujoco/mujoco.h>

#include <cmath>
#include <memory>
#include <mutex>

#include "robot/robot.h"

namespace primo::robot {
namespace {

using ModelPointer = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;

Result<ModelPointer> load_mjcf(const std::filesystem::path& path) {
  // MuJoCo's XML loader keeps the last parsed model in a global.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  PRIMO_TRY([&]() -> Status {
    auto text = read_file(path);
    if (!text.ok()) return text.error();
    return success();
  }());
  char message[1000] = "";
  ModelPointer model(mj_loadXML(path.c_str(), nullptr, message, sizeof message), &mj_deleteModel);
  if (!model) return Error{Code::config, path.string() + ": not a valid MJCF model: " + message};
  return model;
}

std::string joined_names(const mjModel& model, mjtObj type, int count) {
  std::string names;
  for (int i = 0; i < count; ++i) {
    const char* name = mj_id2name(&model, type, i);
    if (name && *name) names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names.empty() ? "none with a name" : names;
}

std::string name_of(const mjModel& model, mjtObj type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name && *name ? name : "#" + std::to_string(id);
}

Pose pose_from(const mjtNum* position, const mjtNum* quaternion) {
  return primo::pose(Eigen::Vector3d(position[0], position[1], position[2]),
                     Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]));
}

/// How an MJCF joint's value follows from q.
struct Drive {
  int index = -1;
  double offset = 0, ratio = 1;
};

}  // namespace

class ModelReader {
 public:
  ModelReader(Robot& robot, const mjModel& model, std::string where)
      : robot_(robot), model_(model), where_(std::move(where)), mjcf_(robot.mjcf_path_.string()) {}

  Status read() {
    PRIMO_TRY(read_joints());
    PRIMO_TRY(read_couplings());
    PRIMO_TRY(read_bodies());
    PRIMO_TRY(read_shapes());
    return read_frames();
  }

 private:
  Error refuse(const std::string& message) const { return Error{Code::config, where_ + ": " + message}; }

  Status add_joint(const std::string& key, const std::string& name, double weight, double home) {
    const int id = mj_name2id(&model_, mjOBJ_JOINT, name.c_str());
    if (id < 0) {
      return refuse(key + ": '" + mjcf_ + "' has no joint '" + name + "'; its joints are " +
                    joined_names(model_, mjOBJ_JOINT, model_.njnt));
    }
    if (drives_[id].index >= 0) return refuse(key + ": joint '" + name + "' is listed twice");
    if (!model_.jnt_limited[id]) {
      return refuse(key + ": joint '" + name + "' has no range in '" + mjcf_ + "'; a planned joint needs limits");
    }
    const double lower = model_.jnt_range[2 * id], upper = model_.jnt_range[2 * id + 1];
    if (!(lower < upper)) return refuse(key + ": joint '" + name + "' has an empty range in '" + mjcf_ + "'");
    if (home < lower || home > upper) {
      return refuse(key + ".home: " + config::detail::format(home) + " is outside the range " +
                    config::detail::format(lower) + " … " + config::detail::format(upper) + " of joint '" + name + "'");
    }
    const auto i = robot_.joint_names_.size();
    drives_[id].index = static_cast<int>(i);
    robot_.joint_names_.push_back(name);
    robot_.slides_.push_back(model_.jnt_type[id] == mjJNT_SLIDE);
    robot_.lower_[i] = lower;
    robot_.upper_[i] = upper;
    robot_.home_[i] = home;
    robot_.control_weights_[i] = weight;
    return success();
  }

  Status read_joints() {
    drives_.resize(model_.njnt);
    const auto& file = robot_.file_;
    if (file.arm.empty()) return refuse("arm: at least one joint must be listed");
    const auto n = static_cast<Eigen::Index>(file.arm.size() + file.hand.size());
    for (auto* vector : {&robot_.lower_, &robot_.upper_, &robot_.home_, &robot_.control_weights_}) vector->setZero(n);
    for (std::size_t i = 0; i < file.arm.size(); ++i) {
      const auto& joint = file.arm[i];
      PRIMO_TRY(add_joint("arm[" + std::to_string(i) + "]", joint.joint, joint.control_weight, joint.home));
    }
    for (std::size_t i = 0; i < file.hand.size(); ++i) {
      const auto& joint = file.hand[i];
      PRIMO_TRY(add_joint("hand[" + std::to_string(i) + "]", joint.joint, joint.control_weight, joint.home));
    }
    return success();
  }

  /// MuJoCo's joint equality: y − y₀ = a₀ + a₁ (x − x₀) + …, y of joint 1, x of joint 2, ₀ the reference positions.
  Status read_couplings() {
    for (int e = 0; e < model_.neq; ++e) {
      if (model_.eq_type[e] != mjEQ_JOINT || !model_.eq_active[e]) continue;
      const int follower = model_.eq_obj1id[e], leader = model_.eq_obj2id[e];
      if (leader < 0) continue;
      const std::string name = name_of(model_, mjOBJ_JOINT, follower);
      const mjtNum* a = model_.eq_data + mjNEQDATA * e;
      if (a[2] != 0 || a[3] != 0 || a[4] != 0) {
        return refuse("'" + mjcf_ + "' couples joint '" + name +
                      "' by a polynomial; only linear couplings (polycoef a0 a1 0 0 0) can be planned with");
      }
      if (drives_[leader].index < 0 || drives_[follower].index >= 0) {
        return refuse("'" + mjcf_ + "' couples joint '" + name + "' to '" + name_of(model_, mjOBJ_JOINT, leader) +
                      "'; the first must not be listed and the second must be listed in the robot file");
      }
      const double x0 = model_.qpos0[model_.jnt_qposadr[leader]], y0 = model_.qpos0[model_.jnt_qposadr[follower]];
      drives_[follower] = {drives_[leader].index, y0 + a[0] - a[1] * x0, a[1]};
    }
    for (int j = 0; j < model_.njnt; ++j) {
      if (drives_[j].index < 0) {
        return refuse("joint '" + name_of(model_, mjOBJ_JOINT, j) + "' of '" + mjcf_ +
                      "' is neither listed as an arm or hand joint nor coupled to one by a joint equality");
      }
    }
    return success();
  }

  Status read_bodies() {
    const int hand_root = model_.jnt_bodyid[mj_name2id(&model_, mjOBJ_JOINT, robot_.file_.arm.back().joint.c_str())];
    for (int b = 0; b < model_.nbody; ++b) {
      Body body;
      body.name = name_of(model_, mjOBJ_BODY, b);
      body.parent = b == 0 ? -1 : model_.body_parentid[b];
      body.hand = b > 0 && (body.parent == hand_root || robot_.bodies_[body.parent].hand);
      robot_.X_PB_.push_back(b == 0 ? Pose::Identity() : pose_from(model_.body_pos + 3 * b, model_.body_quat + 4 * b));
      robot_.turned_.push_back(!robot_.X_PB_.back().linear().isIdentity(0));
      robot_.first_joint_.push_back(static_cast<int>(robot_.chain_.size()));
      robot_.moving_.push_back(b == 0 ? std::vector<int>{} : robot_.moving_[body.parent]);
      for (int j = model_.body_jntadr[b]; j < model_.body_jntadr[b] + model_.body_jntnum[b]; ++j) {
        PRIMO_TRY(add_chain_joint(b, j));
      }
      robot_.bodies_.push_back(std::move(body));
    }
    robot_.first_joint_.push_back(static_cast<int>(robot_.chain_.size()));
    return success();
  }

  Status add_chain_joint(int b, int j) {
    const int type = model_.jnt_type[j];
    if (type != mjJNT_HINGE && type != mjJNT_SLIDE) {
      return refuse("joint '" + name_of(model_, mjOBJ_JOINT, j) + "' of '" + mjcf_ +
                    "' is a ball or free joint; a robot's joints must be hinges or slides");
    }
    ChainJoint joint;
    joint.name = name_of(model_, mjOBJ_JOINT, j);
    joint.body = b;
    joint.index = drives_[j].index;
    joint.slide = type == mjJNT_SLIDE;
    joint.offset = drives_[j].offset;
    joint.ratio = drives_[j].ratio;
    joint.reference = model_.qpos0[model_.jnt_qposadr[j]];
    joint.anchor = Eigen::Map<const Eigen::Vector3d>(model_.jnt_pos + 3 * j);
    joint.axis = Eigen::Map<const Eigen::Vector3d>(model_.jnt_axis + 3 * j).normalized();
    robot_.moving_[b].push_back(static_cast<int>(robot_.chain_.size()));
    robot_.chain_.push_back(std::move(joint));
    return success();
  }

  Status read_shapes() {
    for (int g = 0; g < model_.ngeom; ++g) {
      if (model_.geom_contype[g] == 0 && model_.geom_conaffinity[g] == 0) continue;  // seen, not felt
      LinkShape link;
      link.body = model_.geom_bodyid[g];
      const char* name = mj_id2name(&model_, mjOBJ_GEOM, g);
      link.name = name && *name ? name : robot_.bodies_[link.body].name;
      switch (model_.geom_type[g]) {
        case mjGEOM_SPHERE:
          link.shape.type = ShapeType::sphere;
          break;
        case mjGEOM_CAPSULE:
          link.shape.type = ShapeType::capsule;
          break;
        case mjGEOM_CYLINDER:
          link.shape.type = ShapeType::cylinder;
          break;
        case mjGEOM_BOX:
          link.shape.type = ShapeType::box;
          break;
        default:
          return refuse("geom '" + link.name + "' of '" + mjcf_ +
                        "' collides but is neither sphere, capsule, cylinder nor box; give it such a shape, or contype "
                        "and conaffinity 0");
      }
      link.shape.size = Eigen::Map<const Eigen::Vector3d>(model_.geom_size + 3 * g);
      link.X_BG = pose_from(model_.geom_pos + 3 * g, model_.geom_quat + 4 * g);
      link.hand = robot_.bodies_[link.body].hand;
      link.moves = !robot_.moving_[link.body].empty();
      if (link.moves) {
        link.cover = sphere_cover(link.shape, kCoverTolerance);
        for (Sphere& sphere : link.cover) sphere.centre = link.X_BG * sphere.centre;
      }
      robot_.link_shapes_.push_back(std::move(link));
    }
    return success();
  }

  Result<Frame> frame(const std::string& key, const FrameSpec& spec) const {
    const int body = mj_name2id(&model_, mjOBJ_BODY, spec.body.c_str());
    if (body < 0) {
      return refuse(key + ".body: '" + mjcf_ + "' has no body '" + spec.body + "'; its bodies are " +
                    joined_names(model_, mjOBJ_BODY, model_.nbody));
    }
    return Frame{body, primo::pose(spec.position, spec.rpy)};
  }

  Status read_frames() {
    PRIMO_ASSIGN(robot_.grasp_frame_, frame("grasp_frame", robot_.file_.grasp_frame));
    for (std::size_t i = 0; i < robot_.file_.fingertips.size(); ++i) {
      const auto& spec = robot_.file_.fingertips[i];
      const std::string key = "fingertips[" + std::to_string(i) + "]";
      Fingertip tip;
      tip.name = spec.name;
      tip.thumb = spec.thumb;
      PRIMO_ASSIGN(tip.frame, frame(key + ".frame", spec.frame));
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t s = 0; s < robot_.link_shapes_.size(); ++s) {
        const LinkShape& link = robot_.link_shapes_[s];
        const double d = (link.X_BG.translation() - tip.frame.X_BF.translation()).norm();
        if (link.body == tip.frame.body && d < nearest) {
          nearest = d;
          tip.link_shape = static_cast<int>(s);
        }
      }
      if (tip.link_shape < 0) {
        return refuse(key + ".frame.body: body '" + spec.frame.body + "' of '" + mjcf_ +
                      "' has no colliding geom; a fingertip needs one to touch with");
      }
      robot_.fingertips_.push_back(std::move(tip));
    }
    return success();
  }

  Robot& robot_;
  const mjModel& model_;
  const std::string where_, mjcf_;
  std::vector<Drive> drives_;  // by MJCF joint
};

Result<Robot> Robot::load(const std::filesystem::path& robot_file) {
  Robot robot;
  PRIMO_ASSIGN(robot.file_, config::read<RobotFile>(robot_file));
  robot.mjcf_path_ = std::filesystem::absolute(robot_file.parent_path() / robot.file_.mjcf).lexically_normal();
  auto model = load_mjcf(robot.mjcf_path_);
  if (!model.ok()) return model.error().at(robot_file.string() + ": mjcf");
  PRIMO_TRY(ModelReader(robot, **model, robot_file.string()).read());
  return robot;
}

}  // namespace primo::robot

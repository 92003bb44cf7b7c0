// Reads a Robot out of its robot file and the compiled MJCF model.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>

#include "robot/couplings.h"
#include "robot/loops.h"
#include "robot/mjcf.h"
#include "robot/robot.h"

namespace primo::robot {
namespace {

std::string joined_names(const mjModel& model, mjtObj type, int count) {
  std::string names;
  for (int i = 0; i < count; ++i) {
    const char* name = mj_id2name(&model, type, i);
    if (name && *name) names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names.empty() ? "none with a name" : names;
}

Pose pose_from(const mjtNum* position, const mjtNum* quaternion) {
  return primo::pose(Eigen::Vector3d(position[0], position[1], position[2]),
                     Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3]));
}

}  // namespace

class ModelReader {
 public:
  ModelReader(Robot& robot, const mjModel& model, std::string where)
      : robot_(robot), model_(model), where_(std::move(where)), mjcf_(robot.mjcf_path_.string()) {}

  Status read() {
    PRIMO_TRY(check_numbers());
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
    if (const int type = model_.jnt_type[id]; type != mjJNT_HINGE && type != mjJNT_SLIDE)
      return refuse(key + ": joint '" + name + "' is a ball or free joint; a robot's joints must be hinges or slides");
    if (!model_.jnt_limited[id]) {
      return refuse(key + ": joint '" + name + "' has no limits in '" + mjcf_ +
                    "'; a planned joint needs them: range=\"…\" and limited=\"true\"");
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

  /// MuJoCo reads "nan" as a number.
  Status check_numbers() const {
    const auto finite = [](const mjtNum* values, int count) {
      return std::all_of(values, values + count, [](mjtNum value) { return std::isfinite(value); });
    };
    const auto& m = model_;
    const bool all = finite(m.qpos0, m.nq) && finite(m.jnt_range, 2 * m.njnt) && finite(m.jnt_axis, 3 * m.njnt) &&
                     finite(m.jnt_pos, 3 * m.njnt) && finite(m.body_pos, 3 * m.nbody) &&
                     finite(m.body_quat, 4 * m.nbody) && finite(m.body_mass, m.nbody) &&
                     finite(m.body_inertia, 3 * m.nbody) && finite(m.geom_pos, 3 * m.ngeom) &&
                     finite(m.geom_quat, 4 * m.ngeom) && finite(m.geom_size, 3 * m.ngeom) &&
                     finite(m.eq_data, mjNEQDATA * m.neq) && finite(m.site_pos, 3 * m.nsite);
    return all ? success() : refuse("'" + mjcf_ + "' holds a pose, size, mass, range or coupling that is not finite");
  }

  Status read_couplings() {
    const std::string where = where_ + ": '" + mjcf_ + "'";
    PRIMO_TRY(solve_couplings(model_, where, drives_));
    robot_.tool_body_ = model_.jnt_bodyid[mj_name2id(&model_, mjOBJ_JOINT, robot_.file_.arm.back().joint.c_str())];
    const ListedJoints listed{robot_.arm_joints(), robot_.tool_body_, robot_.joint_names_,
                              robot_.home_,        robot_.lower_,     robot_.upper_};
    PRIMO_ASSIGN(robot_.loops_, close_loops(model_, where, listed, drives_));
    for (int j = 0; j < model_.njnt; ++j) {
      if (drives_[j].index < 0) {
        return refuse(
            "joint '" + name_of(model_, mjOBJ_JOINT, j) + "' of '" + mjcf_ +
            "' is neither listed as an arm or hand joint nor coupled to one by a joint or tendon equality or a loop");
      }
    }
    return success();
  }

  /// Arm joints from the base outwards, hand joints beyond the last of them: the hand is what that one carries.
  Status check_order() const {
    const auto& file = robot_.file_;
    int before = 0;
    for (std::size_t i = 0; i < file.arm.size(); ++i) {
      const int body = model_.jnt_bodyid[mj_name2id(&model_, mjOBJ_JOINT, file.arm[i].joint.c_str())];
      int up = body;
      while (up > 0 && up != before) up = model_.body_parentid[up];
      if (up != before) {
        return refuse("arm[" + std::to_string(i) + "]: joint '" + file.arm[i].joint +
                      "' is not moved by the joint before it; list the arm's joints from the base outwards");
      }
      before = body;
    }
    for (std::size_t i = 0; i < file.hand.size(); ++i) {
      const auto& spec = file.hand[i];
      const std::string key = "hand[" + std::to_string(i) + "]";
      if (!robot_.bodies_[model_.jnt_bodyid[mj_name2id(&model_, mjOBJ_JOINT, spec.joint.c_str())]].hand)
        return refuse(key + ": joint '" + spec.joint + "' is not moved by the last arm joint, '" +
                      file.arm.back().joint + "'");
      if (spec.closing != 0 && !(spec.kp > 0 && spec.max_torque >= std::abs(spec.closing))) {
        return refuse(key + ": joint '" + spec.joint +
                      "' closes, so it needs kp > 0 and max_torque of at least |closing| to keep pressing");
      }
    }
    return success();
  }

  Status read_bodies() {
    for (int b = 0; b < model_.nbody; ++b) {
      Body body;
      body.name = name_of(model_, mjOBJ_BODY, b);
      body.parent = b == 0 ? -1 : model_.body_parentid[b];
      body.hand = b > 0 && (body.parent == robot_.tool_body_ || robot_.bodies_[body.parent].hand);
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
    return check_order();
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
    joint.curve = drives_[j].curve;
    joint.reference = model_.qpos0[model_.jnt_qposadr[j]];
    joint.anchor = Eigen::Map<const Eigen::Vector3d>(model_.jnt_pos + 3 * j);
    joint.axis = Eigen::Map<const Eigen::Vector3d>(model_.jnt_axis + 3 * j).normalized();
    for (int k = 0; k < 3; ++k) {
      if (std::abs(joint.axis[k]) == 1.0) joint.principal = k;
    }
    joint.centred = joint.anchor.isZero(0);
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
                        "' collides but is neither sphere, capsule, cylinder, box nor mesh; give it such a shape, or "
                        "contype and conaffinity 0");
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
    const Pose X = primo::pose(spec.position, spec.rpy);
    if (spec.body.empty() == spec.site.empty()) return refuse(key + ": must name either a body or a site");
    if (!spec.site.empty()) {
      const int site = mj_name2id(&model_, mjOBJ_SITE, spec.site.c_str());
      if (site < 0) {
        return refuse(key + ".site: '" + mjcf_ + "' has no site '" + spec.site + "'; its sites are " +
                      joined_names(model_, mjOBJ_SITE, model_.nsite));
      }
      return Frame{model_.site_bodyid[site], pose_from(model_.site_pos + 3 * site, model_.site_quat + 4 * site) * X};
    }
    const int body = mj_name2id(&model_, mjOBJ_BODY, spec.body.c_str());
    if (body < 0) {
      return refuse(key + ".body: '" + mjcf_ + "' has no body '" + spec.body + "'; its bodies are " +
                    joined_names(model_, mjOBJ_BODY, model_.nbody));
    }
    return Frame{body, X};
  }

  Status read_frames() {
    PRIMO_ASSIGN(robot_.grasp_frame_, frame("grasp_frame", robot_.file_.grasp_frame));
    if (robot_.grasp_frame_.body != robot_.tool_body_ && !robot_.bodies_[robot_.grasp_frame_.body].hand)
      return refuse("grasp_frame: the last arm joint does not move it; it must be of the hand");
    if (const auto tips = robot_.file_.fingertips.size(); tips < 2 || tips > 5)
      return refuse("fingertips: " + std::to_string(tips) + " are listed, must be 2 … 5");
    for (std::size_t i = 0; i < robot_.file_.fingertips.size(); ++i) {
      const auto& spec = robot_.file_.fingertips[i];
      const std::string key = "fingertips[" + std::to_string(i) + "]";
      Fingertip tip;
      tip.name = spec.name;
      tip.thumb = spec.thumb;
      PRIMO_ASSIGN(tip.frame, frame(key + ".frame", spec.frame));
      if (!robot_.bodies_[tip.frame.body].hand)
        return refuse(key + ": fingertip '" + spec.name + "' is not beyond the last arm joint's own body");
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
        return refuse(key + ".frame: body '" + robot_.bodies_[tip.frame.body].name + "' of '" + mjcf_ +
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
  const auto fail = [&](const Error& error) { return error.at(robot_file.string() + ": mjcf"); };
  auto text = read_mjcf(robot.mjcf_path_, primo::pose(robot.file_.base.position, robot.file_.base.rpy));
  if (!text.ok()) return fail(text.error());
  robot.mjcf_ = std::move(text).value();
  auto model = compile_robot(robot.mjcf_, robot.mjcf_path_);
  if (!model.ok()) return fail(model.error());
  PRIMO_TRY(ModelReader(robot, **model, robot_file.string()).read());
  return robot;
}

}  // namespace primo::robot

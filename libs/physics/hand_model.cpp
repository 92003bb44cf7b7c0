#include "physics/hand_model.h"

#include <algorithm>
#include <array>

namespace primo::physics {
namespace {

/// Writes one subtree of a compiled model as MJCF.
class SubtreeWriter {
 public:
  SubtreeWriter(const mjModel* model, int root)
      : m_(model), root_(root), inside_(static_cast<std::size_t>(model->nbody), false) {
    for (int b = root; b < model->nbody; ++b) {
      inside_[static_cast<std::size_t>(b)] = b == root || inside_[static_cast<std::size_t>(model->body_parentid[b])];
    }
  }

  Result<std::string> bodies() {
    PRIMO_TRY(body(root_, "    "));
    return text_;
  }

  std::string equalities() const {
    std::string text;
    for (int e = 0; e < m_->neq; ++e) {
      const bool connects = m_->eq_type[e] == mjEQ_CONNECT;
      if (m_->eq_active[e] && (connects || m_->eq_type[e] == mjEQ_WELD)) {
        text += connects ? connect(e) : weld(e);
        continue;
      }
      const bool joints = m_->eq_type[e] == mjEQ_JOINT;
      if ((!joints && m_->eq_type[e] != mjEQ_TENDON) || !m_->eq_active[e]) continue;
      const int id1 = m_->eq_obj1id[e], id2 = m_->eq_obj2id[e];
      const auto present = [&](int id) { return joints ? inside(m_->jnt_bodyid[id]) : tendon_inside(id); };
      if (!present(id1) || (id2 >= 0 && !present(id2))) continue;
      const std::string kind = joints ? "joint" : "tendon";
      const mjtObj type = joints ? mjOBJ_JOINT : mjOBJ_TENDON;
      text += "    <" + kind + " " + kind + "1=\"" + name(type, id1) + "\"";
      if (id2 >= 0) text += " " + kind + "2=\"" + name(type, id2) + "\"";
      text += attribute("polycoef", m_->eq_data + mjNEQDATA * e, 5) + solver(e);
    }
    return text;
  }

  /// Fixed tendons of the hand's joints: what couples them, springs and limits.
  std::string tendons() const {
    std::string text;
    for (int t = 0; t < m_->ntendon; ++t) {
      if (!tendon_inside(t)) continue;
      text += "    <fixed name=\"" + name(mjOBJ_TENDON, t) + "\"" +
              (m_->tendon_limited[t] ? " limited=\"true\"" + attribute("range", m_->tendon_range + 2 * t, 2)
                                     : std::string()) +
              attribute("margin", m_->tendon_margin + t, 1) + attribute("stiffness", m_->tendon_stiffness + t, 1) +
              attribute("damping", m_->tendon_damping + t, 1) +
              attribute("frictionloss", m_->tendon_frictionloss + t, 1) +
              attribute("springlength", m_->tendon_lengthspring + t, 1) +
              attribute("solreflimit", m_->tendon_solref_lim + mjNREF * t, mjNREF) +
              attribute("solimplimit", m_->tendon_solimp_lim + mjNIMP * t, mjNIMP) +
              attribute("solreffriction", m_->tendon_solref_fri + mjNREF * t, mjNREF) +
              attribute("solimpfriction", m_->tendon_solimp_fri + mjNIMP * t, mjNIMP) + ">\n";
      for (int w = m_->tendon_adr[t]; w < m_->tendon_adr[t] + m_->tendon_num[t]; ++w) {
        text += "      <joint joint=\"" + name(mjOBJ_JOINT, m_->wrap_objid[w]) + "\"" +
                attribute("coef", m_->wrap_prm + w, 1) + "/>\n";
      }
      text += "    </fixed>\n";
    }
    return text.empty() ? text : "  <tendon>\n" + text + "  </tendon>\n";
  }

 private:
  std::string solver(int e) const {
    return attribute("solref", m_->eq_solref + mjNREF * e, mjNREF) +
           attribute("solimp", m_->eq_solimp + mjNIMP * e, mjNIMP) + "/>\n";
  }

  /// The two bodies of an equality; nothing when one of them is not of this subtree.
  std::string bodies_of(int e) const {
    const int id1 = m_->eq_obj1id[e], id2 = m_->eq_obj2id[e];
    if (!inside(id1) || !inside(id2)) return {};
    return " body1=\"" + name(mjOBJ_BODY, id1) + "\" body2=\"" + name(mjOBJ_BODY, id2) + "\"";
  }

  std::string connect(int e) const {
    const std::string bodies = bodies_of(e);
    // Where the second body has the anchor MuJoCo finds again from the joints' reference positions.
    return bodies.empty() ? bodies
                          : "    <connect" + bodies + attribute("anchor", m_->eq_data + mjNEQDATA * e, 3) + solver(e);
  }

  /// MuJoCo's eq_data of a weld: anchor in the second body, pose of the second body in the first, torque scale.
  std::string weld(int e) const {
    const std::string bodies = bodies_of(e);
    const mjtNum* data = m_->eq_data + mjNEQDATA * e;
    return bodies.empty() ? bodies
                          : "    <weld" + bodies + attribute("anchor", data, 3) + attribute("relpose", data + 3, 7) +
                                attribute("torquescale", data + 10, 1) + solver(e);
  }

  bool inside(int b) const { return inside_[static_cast<std::size_t>(b)]; }
  bool tendon_inside(int t) const {
    for (int w = m_->tendon_adr[t]; w < m_->tendon_adr[t] + m_->tendon_num[t]; ++w) {
      // The robot's reader lets tendons through sites pass only when they do nothing.
      if (m_->wrap_type[w] != mjWRAP_JOINT || !inside(m_->jnt_bodyid[m_->wrap_objid[w]])) return false;
    }
    return true;
  }

  std::string name(mjtObj type, int id) const {
    const char* text = mj_id2name(m_, type, id);
    // Nameless elements get a name that no MJCF file is likely to use; only joints of equalities need one.
    return text && *text ? xml_escape(text)
                         : "primo:" + std::to_string(static_cast<int>(type)) + ":" + std::to_string(id);
  }

  static std::string attribute(const char* key, const mjtNum* values, int count) {
    return std::string(" ") + key + "=\"" + numbers(values, count) + "\"";
  }

  Status body(int b, const std::string& indent) {
    text_ += indent + "<body name=\"" + name(mjOBJ_BODY, b) + "\"";
    if (b != root_) text_ += attribute("pos", m_->body_pos + 3 * b, 3) + attribute("quat", m_->body_quat + 4 * b, 4);
    text_ += ">\n";
    if (m_->body_mass[b] > 0) {
      text_ += indent + "  <inertial" + attribute("pos", m_->body_ipos + 3 * b, 3) +
               attribute("quat", m_->body_iquat + 4 * b, 4) + attribute("mass", m_->body_mass + b, 1) +
               attribute("diaginertia", m_->body_inertia + 3 * b, 3) + "/>\n";
    }
    // The root's own joints are what fixes the hand: they are left out.
    for (int j = m_->body_jntadr[b]; b != root_ && j >= 0 && j < m_->body_jntadr[b] + m_->body_jntnum[b]; ++j) {
      PRIMO_TRY(joint(j, indent));
    }
    for (int g = m_->body_geomadr[b]; g >= 0 && g < m_->body_geomadr[b] + m_->body_geomnum[b]; ++g)
      PRIMO_TRY(geom(g, indent));
    for (int child = b + 1; child < m_->nbody; ++child) {
      if (m_->body_parentid[child] == b) PRIMO_TRY(body(child, indent + "  "));
    }
    text_ += indent + "</body>\n";
    return success();
  }

  Status joint(int j, const std::string& indent) {
    const int type = m_->jnt_type[j];
    if (type != mjJNT_HINGE && type != mjJNT_SLIDE) {
      return Error{Code::config, "joint '" + name(mjOBJ_JOINT, j) + "' of the hand is neither a hinge nor a slide"};
    }
    const int dof = m_->jnt_dofadr[j], position = m_->jnt_qposadr[j];
    text_ += indent + "  <joint name=\"" + name(mjOBJ_JOINT, j) + "\" type=\"" +
             (type == mjJNT_HINGE ? "hinge" : "slide") + "\"" + attribute("pos", m_->jnt_pos + 3 * j, 3) +
             attribute("axis", m_->jnt_axis + 3 * j, 3) +
             (m_->jnt_limited[j] ? " limited=\"true\"" + attribute("range", m_->jnt_range + 2 * j, 2) : std::string()) +
             attribute("ref", m_->qpos0 + position, 1) + attribute("springref", m_->qpos_spring + position, 1) +
             attribute("stiffness", m_->jnt_stiffness + j, 1) + attribute("margin", m_->jnt_margin + j, 1) +
             attribute("solreflimit", m_->jnt_solref + mjNREF * j, mjNREF) +
             attribute("solimplimit", m_->jnt_solimp + mjNIMP * j, mjNIMP) +
             attribute("solreffriction", m_->dof_solref + mjNREF * dof, mjNREF) +
             attribute("solimpfriction", m_->dof_solimp + mjNIMP * dof, mjNIMP) +
             attribute("armature", m_->dof_armature + dof, 1) + attribute("damping", m_->dof_damping + dof, 1) +
             attribute("frictionloss", m_->dof_frictionloss + dof, 1) + "/>\n";
    return success();
  }

  Status geom(int g, const std::string& indent) {
    if (m_->geom_contype[g] == 0 && m_->geom_conaffinity[g] == 0) return success();
    const char* type = nullptr;
    switch (m_->geom_type[g]) {
      case mjGEOM_SPHERE:
        type = "sphere";
        break;
      case mjGEOM_CAPSULE:
        type = "capsule";
        break;
      case mjGEOM_CYLINDER:
        type = "cylinder";
        break;
      case mjGEOM_BOX:
        type = "box";
        break;
      case mjGEOM_ELLIPSOID:
        type = "ellipsoid";
        break;
      default:
        return Error{Code::config,
                     "geom '" + name(mjOBJ_GEOM, g) +
                         "' of the hand collides and is not a sphere, capsule, cylinder, box or ellipsoid"};
    }
    const std::array<mjtNum, 2> bits = {static_cast<mjtNum>(m_->geom_contype[g]),
                                        static_cast<mjtNum>(m_->geom_conaffinity[g])};
    const mjtNum condim = m_->geom_condim[g], priority = m_->geom_priority[g];
    text_ += indent + "  <geom type=\"" + type + "\"" + attribute("size", m_->geom_size + 3 * g, 3) +
             attribute("pos", m_->geom_pos + 3 * g, 3) + attribute("quat", m_->geom_quat + 4 * g, 4) +
             attribute("contype", bits.data(), 1) + attribute("conaffinity", bits.data() + 1, 1) +
             attribute("condim", &condim, 1) + attribute("priority", &priority, 1) +
             attribute("friction", m_->geom_friction + 3 * g, 3) + attribute("solmix", m_->geom_solmix + g, 1) +
             attribute("solref", m_->geom_solref + mjNREF * g, mjNREF) +
             attribute("solimp", m_->geom_solimp + mjNIMP * g, mjNIMP) + attribute("margin", m_->geom_margin + g, 1) +
             attribute("gap", m_->geom_gap + g, 1) + " mass=\"0\" group=\"2\"/>\n";
    return success();
  }

  const mjModel* m_;
  int root_;
  std::vector<bool> inside_;
  std::string text_;
};

Eigen::Vector3d vector3(const mjtNum* values) { return {values[0], values[1], values[2]}; }

}  // namespace

Result<Model> robot_model(const robot::Robot& robot) {
  const auto& path = robot.mjcf_path();
  auto model =
      compile("<mujoco model=\"robot\">" + robot.mjcf() + "</mujoco>", path.parent_path(), "robot " + path.string());
  if (model.ok()) PRIMO_TRY(prepare_robot(robot, *model));
  return model;
}

namespace {

/// Sizes for a hand: contacts of each shape, a few constraints of each joint. Never less than a three-fingered hand
/// needs.
std::string hand_size_mjcf(const robot::Robot& robot) {
  const auto& links = robot.link_shapes();
  const auto shapes = static_cast<int>(std::count_if(links.begin(), links.end(), [](const auto& l) { return l.hand; }));
  const auto joints = static_cast<int>(robot.chain().size());
  const int rows = std::max(300, 24 * shapes + 3 * joints) + 6 * static_cast<int>(robot.loops().size()),
            contacts = std::max(60, 6 * shapes);
  return "  <size njmax=\"" + std::to_string(rows) + "\" nconmax=\"" + std::to_string(contacts) + "\" nstack=\"" +
         std::to_string(std::max(100000, 8 * rows * (joints + 6))) + "\"/>\n";
}

}  // namespace

Pose palm_pose(const robot::Robot& robot, const Eigen::VectorXd& q) {
  return robot.forward(q).X_WB[static_cast<std::size_t>(robot.tool_body())];
}

Result<HandMjcf> hand_mjcf(const robot::Robot& robot, const mjModel* model) {
  const std::string& last = robot.file().arm.back().joint;
  const int joint = mj_name2id(model, mjOBJ_JOINT, last.c_str());
  if (joint < 0) return Error{Code::config, robot.mjcf_path().string() + ": no joint '" + last + "'"};
  SubtreeWriter writer(model, model->jnt_bodyid[joint]);
  auto bodies = writer.bodies();
  if (!bodies.ok()) return bodies.error().at(robot.mjcf_path().string());
  return HandMjcf{std::move(bodies).value(), writer.equalities(), writer.tendons()};
}

Result<Model> hand_model(const robot::Robot& robot, const mjModel* model, const Shape& object, double mass,
                         double timestep) {
  PRIMO_ASSIGN(const HandMjcf parts, hand_mjcf(robot, model));
  const std::string name = kHandObject;
  std::string mjcf =
      "<mujoco model=\"hand\">\n  <compiler angle=\"radian\" autolimits=\"true\" boundmass=\"1e-6\" "
      "boundinertia=\"1e-10\"/>\n" +
      solver_mjcf(timestep) + hand_size_mjcf(robot) + "  <worldbody>\n" + parts.bodies + "    <body name=\"" + name +
      "\">\n      <joint name=\"" + name + "\" type=\"free\"/>\n      <geom name=\"" + name + "\"" +
      shape_attributes(object) + " mass=\"" + numbers(&mass, 1) + "\" group=\"1\"" + contact_attributes() +
      "/>\n    </body>\n  </worldbody>\n  <equality>\n" + parts.equalities + "  </equality>\n" + parts.tendons +
      "</mujoco>\n";
  auto hand = compile(mjcf, {}, "hand of " + robot.mjcf_path().string());
  if (hand.ok()) std::fill_n(hand.value()->opt.gravity, 3, 0.0);
  return hand;
}

void apply_frame_forces(const mjModel* model, mjData* data, const ShakerState& shaker, const Eigen::Vector3d& centre,
                        const Eigen::Vector3d& gravity_N) {
  const Eigen::Vector3d lift = shaker.R_NP.transpose() * gravity_N - shaker.acceleration;
  const Eigen::Vector3d &omega = shaker.omega, &alpha = shaker.alpha;
  for (int b = 1; b < model->nbody; ++b) {
    const double mass = model->body_mass[b];
    // A body welded to the world needs no force: none of its parts can move.
    if (mass <= 0 || model->body_weldid[b] == 0) continue;
    std::array<mjtNum, 6> velocity{};
    mj_objectVelocity(model, data, mjOBJ_BODY, b, velocity.data(), 0);
    const Eigen::Vector3d w = vector3(velocity.data()), v = vector3(velocity.data() + 3),
                          r = vector3(data->xipos + 3 * b) - centre;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data->ximat + 9 * b);
    const Eigen::Matrix3d I = R * vector3(model->body_inertia + 3 * b).asDiagonal() * R.transpose();
    const Eigen::Vector3d force = mass * (lift - alpha.cross(r) - omega.cross(omega.cross(r)) - 2 * omega.cross(v));
    const Eigen::Vector3d Iomega = I * omega;
    const Eigen::Vector3d torque =
        -(I * alpha + I * omega.cross(w) + omega.cross(Iomega) + omega.cross(I * w) + w.cross(Iomega));
    Eigen::Map<Eigen::Vector3d>(data->xfrc_applied + 6 * b) = force;
    Eigen::Map<Eigen::Vector3d>(data->xfrc_applied + 6 * b + 3) = torque;
  }
}

}  // namespace primo::physics

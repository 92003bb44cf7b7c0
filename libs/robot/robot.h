// A robot read from its robot file and MJCF: joints, limits, hand, grasp frame and the kinematic chain.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "config/config.h"
#include "core/pose.h"
#include "core/result.h"
#include "robot/curve.h"
#include "robot/shape.h"
#include "robot/sphere_cover.h"

namespace primo::robot {

/// A frame fixed to a body of the MJCF model (X_BF), or to a site of it (X_SF).
struct FrameSpec {
  std::string body, site;             ///< one of them
  Eigen::Vector3d position{0, 0, 0};  ///< of the frame in the body or site, m
  Eigen::Vector3d rpy{0, 0, 0};       ///< rad
  template <class V>
  void visit(V&& v) {
    v("body", body, {.help = "body of the MJCF model"});
    v("site", site, {.help = "site of the MJCF model, instead of a body"});
    v("position", position, {.help = "in the body or site", .unit = "m"});
    v("rpy", rpy, {.unit = "rad"});
  }
};

/// A fingertip: the centre of its pad and the pad's outward normal (towards a grasped object).
struct FingertipSpec {
  std::string name;
  FrameSpec frame;     ///< origin: the tip's centre; z: the pad's outward normal
  bool thumb = false;  ///< opposes the others; a hand without a thumb grips from any two opposite sides
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("frame", frame, {.help = "origin: the tip's centre; z: the pad's outward normal", .required = true});
    v("thumb", thumb, {.help = "opposes the others"});
  }
};

/// Where the model's origin stands: X_WM.
struct BaseSpec {
  Eigen::Vector3d position{0, 0, 0};  ///< in W, m
  Eigen::Vector3d rpy{0, 0, 0};       ///< rad
  template <class V>
  void visit(V&& v) {
    v("position", position, {.help = "in the world", .unit = "m", .min = -100, .max = 100});
    v("rpy", rpy, {.unit = "rad"});
  }
};

/// Numbers of a joint that slides are in metres and newtons instead of radians and newton metres.
struct ArmJointSpec {
  std::string joint;
  double control_weight = 1.0;  ///< W
  double home = 0.0;            ///< rad
  double max_speed = 2.0;       ///< rad/s
  double kp = 0, kd = 0;        ///< tracking gains in execution, N·m/rad and N·m·s/rad
  double max_torque = 0;        ///< N·m
  template <class V>
  void visit(V&& v) {
    v("joint", joint, {.required = true});
    v("control_weight", control_weight, {.help = "W", .min = 1e-9});
    v("home", home, {.help = "slides: m", .unit = "rad"});
    v("max_speed", max_speed, {.help = "slides: m/s", .unit = "rad/s", .min = 1e-6});
    v("kp", kp, {.help = "slides: N/m", .unit = "N·m/rad", .min = 0});
    v("kd", kd, {.help = "slides: N·s/m", .unit = "N·m·s/rad", .min = 0});
    v("max_torque", max_torque, {.help = "slides: N", .unit = "N·m", .min = 0});
  }
};

struct HandJointSpec {
  std::string joint;
  double control_weight = 0.1;
  double home = 0.0;      ///< rad, fingers open
  double closing = 0.0;   ///< N·m and direction: torque that closes the hand on an object; 0: held
  double kp = 0, kd = 0;  ///< position servo, N·m/rad and N·m·s/rad
  double max_torque = 0;  ///< N·m
  template <class V>
  void visit(V&& v) {
    v("joint", joint, {.required = true});
    v("control_weight", control_weight, {.help = "W", .min = 1e-9});
    v("home", home, {.help = "fingers open; slides: m", .unit = "rad"});
    v("closing", closing,
      {.help = "signed torque that closes the hand (slides: force, N); 0: the joint is held", .unit = "N·m"});
    v("kp", kp, {.help = "slides: N/m", .unit = "N·m/rad", .min = 0});
    v("kd", kd, {.help = "slides: N·s/m", .unit = "N·m·s/rad", .min = 0});
    v("max_torque", max_torque, {.help = "slides: N", .unit = "N·m", .min = 0});
  }
};

/// A robot file (YAML, see docs/robots.md). Joint order of every q in primo: arm joints, then hand joints. Joints that
/// an MJCF equality or a loop of the hand couples to a listed one follow it and are not listed.
struct RobotFile {
  std::string name;
  std::string mjcf;  ///< relative to the robot file
  BaseSpec base;     ///< where the model's origin stands in the world
  std::vector<ArmJointSpec> arm;
  std::vector<HandJointSpec> hand;
  /// origin: where the object's centre should be; z: approach; x: opposition, thumb to fingers (or finger to finger)
  FrameSpec grasp_frame;
  std::vector<FingertipSpec> fingertips;
  template <class V>
  void visit(V&& v) {
    v("name", name, {.required = true});
    v("mjcf", mjcf, {.help = "MJCF model, relative to this file", .required = true});
    v("base", base, {.help = "where the model's origin stands in the world"});
    v("arm", arm, {.help = "arm joints from the base outwards", .required = true});
    v("hand", hand, {.help = "independent hand joints", .required = true});
    v("grasp_frame", grasp_frame,
      {.help = "origin: where the object's centre should be; z: approach; x: opposition, thumb to fingers",
       .required = true});
    v("fingertips", fingertips, {.help = "2 … 5", .required = true});
  }
};

/// A frame fixed to body `body` (an index into Robot::bodies()): X_BF.
struct Frame {
  int body = 0;
  Pose X_BF = Pose::Identity();
};

struct Fingertip {
  std::string name;
  Frame frame;         ///< origin: the tip's centre; z: the pad's outward normal
  bool thumb = false;  ///< opposes the others
  int link_shape =
      -1;  ///< the collision shape of the tip's body that is nearest to the tip's centre: its distal phalanx
};

/// A body of the chain. Parents come before their children; body 0 is the world.
struct Body {
  std::string name;
  int parent = -1;
  bool hand = false;  ///< moved by a hand joint, or rigidly fixed to a link that the last arm joint moves
};

/// A collision shape fixed to a body: X_BG.
struct LinkShape {
  std::string name;  ///< the geom's name, or its body's where it has none
  int body = 0;
  Pose X_BG = Pose::Identity();
  Shape shape;
  bool hand = false;               ///< of the hand, not the arm
  bool moves = false;              ///< at least one joint moves it
  std::vector<Sphere> cover = {};  ///< spheres that hold it, within kCoverTolerance of it; centres in the body's frame
};

inline constexpr double kCoverTolerance = 0.01;  ///< m

/// Two bodies of the hand that an equality holds together, beside the tree that their joints make: by index.
struct Loop {
  int body = 0, other = 0;
};

/// One scalar MJCF joint between a body and its parent. Its value is offset + ratio · q[index], or curve(q[index]) in a
/// loop of the hand; then ratio is the curve's steepest slope.
struct ChainJoint {
  std::string name;
  int body = 0;
  int index = 0;       ///< which q drives it
  bool slide = false;  ///< translation along the axis; else a hinge
  double offset = 0, ratio = 1;
  std::shared_ptr<const Curve> curve = nullptr;
  double reference = 0;             ///< the value at which the joint displaces nothing
  Eigen::Vector3d anchor{0, 0, 0};  ///< in the body frame, m
  Eigen::Vector3d axis{0, 0, 1};    ///< unit, in the body frame
  int principal = -1;               ///< which coordinate axis it is, ±; −1: none
  bool centred = false;             ///< whether the anchor is the body's origin

  /// At this value of q[index].
  double value(double q) const { return curve ? curve->value(q) : offset + ratio * q; }
  /// Its derivative there.
  double slope(double q) const { return curve ? curve->slope(q) : ratio; }
};

/// Where everything is at one q. Reused between calls: forward() allocates only on the first.
struct Kinematics {
  std::vector<Pose> X_WB;                 ///< by body
  std::vector<Eigen::Vector3d> anchor_W;  ///< by chain joint, m
  std::vector<Eigen::Vector3d> axis_W;    ///< by chain joint, unit
  std::vector<double> slope;              ///< by chain joint: its speed for unit speed of the q that drives it
};

/// The kinematic chain of a robot file, read out of its MJCF model once. Immutable: one object serves any number of
/// threads. n is the number of listed joints, arm then hand; every q has n entries in radians (metres for slides).
class Robot {
 public:
  /// Reads a robot file and the MJCF model it names. Errors name the file, what is wrong there and what would be right:
  /// the missing joint or body and those that exist, a feature that MuJoCo 2.2 does not read and its line.
  static Result<Robot> load(const std::filesystem::path& robot_file);

  const std::string& name() const { return file_.name; }
  const RobotFile& file() const { return file_; }
  const std::filesystem::path& mjcf_path() const { return mjcf_path_; }
  /// The model's sections as one text, to be put into a <mujoco> element (see mjcf.h).
  const std::string& mjcf() const { return mjcf_; }

  int joints() const { return static_cast<int>(joint_names_.size()); }
  int arm_joints() const { return static_cast<int>(file_.arm.size()); }
  int hand_joints() const { return static_cast<int>(file_.hand.size()); }
  const std::vector<std::string>& joint_names() const { return joint_names_; }
  /// Whether listed joint i translates: its values are metres, its efforts newtons.
  bool slides(int i) const { return slides_[static_cast<std::size_t>(i)] != 0; }
  /// What of joint i counts as one radian where joints are summed or compared: 1 for hinges; a slide's whole range
  /// counts as half a turn (m).
  double radian(int i) const { return slides(i) ? (upper_[i] - lower_[i]) / std::numbers::pi : 1.0; }
  const Eigen::VectorXd& lower() const { return lower_; }                      ///< rad (slides: m)
  const Eigen::VectorXd& upper() const { return upper_; }                      ///< rad (slides: m)
  const Eigen::VectorXd& home() const { return home_; }                        ///< rad (slides: m)
  const Eigen::VectorXd& control_weights() const { return control_weights_; }  ///< the diagonal of W

  const std::vector<Body>& bodies() const { return bodies_; }
  const std::vector<ChainJoint>& chain() const { return chain_; }
  const std::vector<LinkShape>& link_shapes() const { return link_shapes_; }
  /// Bodies that equalities hold together, beside the tree. forward() has the loops closed.
  const std::vector<Loop>& loops() const { return loops_; }
  /// The body that the last arm joint moves: the hand's frame P.
  int tool_body() const { return tool_body_; }
  const Frame& grasp_frame() const { return grasp_frame_; }
  const std::vector<Fingertip>& fingertips() const { return fingertips_; }

  /// The index of the body of this name, or −1.
  int body(const std::string& name) const;

  /// Poses of all bodies at q. @pre q.size() == joints().
  void forward(const Eigen::Ref<const Eigen::VectorXd>& q, Kinematics& out) const;
  Kinematics forward(const Eigen::Ref<const Eigen::VectorXd>& q) const;

  /// X_WF at these kinematics.
  Pose pose(const Kinematics& kinematics, const Frame& frame) const { return kinematics.X_WB[frame.body] * frame.X_BF; }
  /// X_WG of a link shape.
  Pose pose(const Kinematics& kinematics, const LinkShape& link) const {
    return kinematics.X_WB[link.body] * link.X_BG;
  }

  /// Adds weightᵀ · ∂p_W/∂q to `row` (1 × n), for the point of `body` now at p_W: the gradient of weightᵀ p_W.
  void add_point_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W,
                          const Eigen::Vector3d& weight, Eigen::Ref<Eigen::RowVectorXd> row) const;
  /// Adds weightᵀ · ∂v_W/∂q to `row` (1 × n), for a vector v fixed to `body` and now v_W.
  void add_vector_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& v_W,
                           const Eigen::Vector3d& weight, Eigen::Ref<Eigen::RowVectorXd> row) const;
  /// Adds weightᵀ · ω_j to `row` (1 × n), ω_j the angular velocity of `body` in W for unit speed of q_j.
  void add_angular_gradient(const Kinematics& kinematics, int body, const Eigen::Vector3d& weight,
                            Eigen::Ref<Eigen::RowVectorXd> row) const;
  /// ∂p_W/∂q (3 × n) of the point of `body` now at p_W.
  Eigen::Matrix3Xd point_jacobian(const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W) const;
  /// ∂v_W/∂q (3 × n) of a vector fixed to `body` and now v_W.
  Eigen::Matrix3Xd vector_jacobian(const Kinematics& kinematics, int body, const Eigen::Vector3d& v_W) const;

 private:
  friend class ModelReader;
  RobotFile file_;
  std::filesystem::path mjcf_path_;
  std::string mjcf_;
  std::vector<std::string> joint_names_;
  std::vector<char> slides_;  // by listed joint
  Eigen::VectorXd lower_, upper_, home_, control_weights_;
  std::vector<Body> bodies_;
  std::vector<Pose> X_PB_;                // by body: in its parent, joints at their reference
  std::vector<char> turned_;              // by body: whether X_PB rotates
  std::vector<ChainJoint> chain_;         // in the order of bodies
  std::vector<int> first_joint_;          // by body: its range in chain_, bodies + 1 entries
  std::vector<std::vector<int>> moving_;  // by body: the chain joints that move it
  std::vector<LinkShape> link_shapes_;
  std::vector<Loop> loops_;
  int tool_body_ = 0;
  Frame grasp_frame_;
  std::vector<Fingertip> fingertips_;
};

}  // namespace primo::robot

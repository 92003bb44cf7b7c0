// Position: a frame's origin relative to an object's centre, or to where the frame's object stands on that object.
#include <cstdio>

#include "motion/task_frames.h"
#include "motion/task_variables.h"
#include "scene/reach.h"

namespace primo::motion {
namespace {

/// Half the extent along the shape's own z axis, m.
double half_height(const Shape& shape) {
  switch (shape.type) {
    case ShapeType::sphere:
      return shape.size[0];
    case ShapeType::capsule:
      return shape.size[0] + shape.size[1];
    case ShapeType::cylinder:
      return shape.size[1];
    case ShapeType::box:
      return shape.size[2];
  }
  return 0;
}

/// φ(q) = p_WF(q) − p_WO(q) − h z_W in W, m (3 rows): paper, IV.A, "reach target". O moves with the hand when it is
/// held. h = 0 for point centre; for point on_top, h is half the heights of F's object and of O, both upright, and the
/// clearance. O may be the world: φ is then the position itself.
class Position final : public TaskVariable {
 public:
  Position(const TaskSetup& setup, const robot::Frame& frame, const robot::Frame& object, double height)
      : robot_(setup.robot),
        frame_(frame),
        object_(object),
        height_W_(0, 0, height),
        frame_name_(setup.of.at("frame")),
        object_name_(setup.of.at("object")) {}
  int size() const override { return 3; }
  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    const Eigen::Vector3d p_WF = origin(at, frame_), p_WO = origin(at, object_);
    phi = p_WF - (p_WO + height_W_);
    if (!J) return;
    J->setZero();
    for (int i = 0; i < 3; ++i) {
      robot_.add_point_gradient(at.kinematics, frame_.body, p_WF, Eigen::Vector3d::Unit(i), J->row(i));
      robot_.add_point_gradient(at.kinematics, object_.body, p_WO, -Eigen::Vector3d::Unit(i), J->row(i));
    }
  }

  std::string explain(const Configuration& at) const override {
    const Eigen::Vector3d p_WF = origin(at, frame_), goal = origin(at, object_) + height_W_;
    char text[80];
    std::snprintf(text, sizeof text, " are %.4f m apart", (p_WF - goal).norm());
    std::string reason = frame_name_ + " and its place at " + object_name_ + text;
    const scene::Reach arm = scene::reach(robot_);
    const double distance = (goal - arm.shoulder_W).norm();
    if (frame_name_ != "grasp" || distance <= arm.longest) return reason;
    std::snprintf(text, sizeof text, ", out of reach: %.2f m from the shoulder, which reaches %.2f m", distance,
                  arm.longest);
    return reason + text;
  }

 private:
  static Eigen::Vector3d origin(const Configuration& at, const robot::Frame& frame) {
    return at.kinematics.X_WB[frame.body] * frame.X_BF.translation();
  }

  const robot::Robot& robot_;
  const robot::Frame frame_, object_;
  const Eigen::Vector3d height_W_;
  const std::string frame_name_, object_name_;
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  PRIMO_ASSIGN(const auto frame, find_frame(setup.robot, setup.scene, setup.of.at("frame")));
  robot::Frame object;
  double height = 0;
  if (setup.of.at("object") != "world") {
    PRIMO_ASSIGN(const auto found, find_object(setup.robot, setup.scene, setup.of.at("object")));
    object = found.frame;
    height = half_height(found.body->shape);
  }
  if (setup.of.at("point") == "on_top") {
    const auto top = find_object(setup.robot, setup.scene, setup.of.at("frame"));
    if (!top.ok()) return top.error().at("position: point on_top is where one object stands on another");
    height += half_height(top->body->shape) + setup.parameters.at("clearance");
  } else {
    height = 0;
  }
  return std::unique_ptr<TaskVariable>(new Position(setup, frame, object, height));
}

}  // namespace

TaskVariableEntry position_task() {
  return {"position",
          "a frame's origin relative to an object's centre or to where it stands on it, m",
          {{"clearance", 0.005, 0, 1, "m, between the two objects at point on_top"}},
          {{"frame", "grasp", {}, kFrameHelp},
           {"object", "target", {}, std::string(kObjectHelp) + ", or world"},
           {"point", "centre", {"centre", "on_top"}, "the object's centre, or where the frame's object stands on it"}},
          create};
}

}  // namespace primo::motion

// Perceived collision: how much the robot and what it holds come too near to what the camera saw as occupied.
#include <algorithm>
#include <cmath>

#include "config/config.h"
#include "motion/task_frames.h"
#include "motion/task_variables.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

/// φ(q) = Σ max(0, 1 − (D(c(q)) − s/2 − r) / margin) over the spheres (c, r) that cover each moving link and the held
/// object (1 row). D is the interpolated distance to the centres of occupied voxels of side s. The held object's own
/// voxels are out of D; from phase `target_until` on, the target's are too for links of the hand, and its support's for
/// a held target. An object's voxels are those within one voxel of its estimated shape. A cover exceeds its shape by up
/// to 1 cm (robot/sphere_cover.h), so that φ counts from at most margin + 1 cm on.
class PerceivedCollision final : public TaskVariable {
 public:
  explicit PerceivedCollision(const TaskSetup& setup)
      : robot_(setup.robot),
        all_(setup.scene.perceived),
        without_contact_(setup.scene.perceived_without_contact),
        margin_(setup.parameters.at("margin")),
        target_until_(setup.parameters.at("target_until")),
        departs_(setup.parameters.at("departs") > 0) {
    const bool held_target = setup.scene.target_is_held();
    for (const auto& link : robot_.link_shapes()) {
      if (link.moves)
        movers_.push_back(mover(link.name, link.body, link.X_BG.translation(), link.cover, link.hand && !held_target));
    }
    if (!setup.scene.held) return;
    const auto held = find_object(robot_, setup.scene, "held").value();
    auto cover = robot::sphere_cover(held.body->shape, robot::kCoverTolerance);
    for (auto& sphere : cover) sphere.centre = held.frame.X_BF * sphere.centre;
    movers_.push_back(
        mover(held.body->name, held.frame.body, held.frame.X_BF.translation(), std::move(cover), held_target));
  }
  int size() const override { return 1; }
  bool departs_from_start() const override { return departs_; }

  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi[0] = 0;
    if (J) J->setZero();
    for_each_near_sphere(
        at, [&](const Mover& mover, const Eigen::Vector3d& c_W, double clearance, const Eigen::Vector3d& gradient) {
          phi[0] += 1 - clearance / margin_;
          if (J) robot_.add_point_gradient(at.kinematics, mover.body, c_W, -gradient / margin_, J->row(0));
        });
  }

  std::string explain(const Configuration& at) const override {
    double nearest = margin_;
    std::string text;
    for_each_near_sphere(at, [&](const Mover& mover, const Eigen::Vector3d&, double clearance, const Eigen::Vector3d&) {
      if (clearance >= nearest) return;
      nearest = clearance;
      text = mover.name + " is " + config::detail::format(std::round(clearance * 1e4) / 1e4) +
             " m from what was perceived";
    });
    return text;
  }

 private:
  struct Mover {
    std::string name;
    int body = 0;
    Eigen::Vector3d centre{0, 0, 0};     // in the body's frame
    double reach = 0;                    // of the cover about the centre, m
    std::vector<robot::Sphere> spheres;  // in the body's frame
    bool comes_near = false;             // to contact(), in the end
  };

  static Mover mover(const std::string& name, int body, const Eigen::Vector3d& centre,
                     std::vector<robot::Sphere> spheres, bool comes_near) {
    Mover mover{name, body, centre, 0, std::move(spheres), comes_near};
    for (const auto& sphere : mover.spheres) {
      mover.reach = std::max(mover.reach, (sphere.centre - centre).norm() + sphere.radius);
    }
    return mover;
  }

  template <class F>
  void for_each_near_sphere(const Configuration& at, F&& f) const {
    const bool late = at.phase >= target_until_ - 1e-9;
    for (const auto& mover : movers_) {
      const scene::DistanceField& field = late && mover.comes_near ? *without_contact_ : *all_;
      const Pose& X_WB = at.kinematics.X_WB[mover.body];
      const double half_voxel = 0.5 * field.resolution();
      Eigen::Vector3d gradient;
      // D differs by at most a voxel's diagonal from a function of slope 1.
      const double far = mover.reach + half_voxel + margin_ + 4 * std::sqrt(3.0) * half_voxel;
      if (field.interpolate(X_WB * mover.centre, gradient) > far) continue;
      for (const auto& sphere : mover.spheres) {
        const Eigen::Vector3d c_W = X_WB * sphere.centre;
        const double clearance = field.interpolate(c_W, gradient) - half_voxel - sphere.radius;
        if (clearance < margin_) f(mover, c_W, clearance, gradient);
      }
    }
  }

  const robot::Robot& robot_;
  const std::shared_ptr<const scene::DistanceField> all_, without_contact_;
  const double margin_, target_until_;
  const bool departs_;
  std::vector<Mover> movers_;
};

Result<std::unique_ptr<TaskVariable>> create(const TaskSetup& setup) {
  if (!setup.scene.perceived) {
    return Error{Code::data, "perceived_collision: the planning scene has no perceived occupancy map"};
  }
  return make_variable<PerceivedCollision>(setup);
}

}  // namespace

TaskVariableEntry perceived_collision_task() {
  return {"perceived_collision",
          "summed proximity of the robot's and the held object's covering spheres to occupied voxels",
          {{"margin", 0.04, 1e-4, 1, "m, the distance from which a sphere counts"},
           {"target_until", 0.8, 0, 2, "phase until which the hand keeps off the target's voxels"},
           {"departs", 1, 0, 1, "1: the target comes linearly from its value at the start, 0: it is y* at once"}},
          {},
          create,
          true};
}

}  // namespace primo::motion

// Collision: how much all links together come too near to what they must not touch.
#include <algorithm>
#include <cmath>

#include "config/config.h"
#include "motion/task_variables.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

/// φ(q) = Σ max(0, 1 − d / margin) over pairs of a moving link and an obstacle or the table (1 row). The target is a
/// pair with every link of the arm throughout, and with the hand's links before phase `target_until`: the hand has to
/// come near it in the end.
class Collision final : public TaskVariable {
 public:
  explicit Collision(const TaskSetup& setup)
      : robot_(setup.robot),
        scene_(setup.scene),
        margin_(setup.parameters.at("margin")),
        target_until_(setup.parameters.at("target_until")) {
    for (const auto& link : robot_.link_shapes()) {
      if (link.moves) links_.push_back({&link, robot::bounding_radius(link.shape)});
    }
  }
  int size() const override { return 1; }
  bool departs_from_start() const override { return true; }

  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi[0] = 0;
    if (J) J->setZero();
    for_each_near_pair(at, [&](const robot::LinkShape& link, const SceneBody&, const robot::Distance& d) {
      phi[0] += 1 - d.distance / margin_;
      if (J) robot_.add_point_gradient(at.kinematics, link.body, d.point_a, -d.gradient / margin_, J->row(0));
    });
  }

  std::string explain(const Configuration& at) const override {
    double nearest = margin_;
    std::string text;
    for_each_near_pair(at, [&](const robot::LinkShape& link, const SceneBody& body, const robot::Distance& d) {
      if (d.distance >= nearest) return;
      nearest = d.distance;
      text = link.name + " and " + body.name + " are " + config::detail::format(std::round(d.distance * 1e4) / 1e4) +
             " m apart";
    });
    return text;
  }

 private:
  struct Link {
    const robot::LinkShape* shape;
    double bounding_radius;
  };

  template <class F>
  void for_each_near_pair(const Configuration& at, F&& f) const {
    const bool keep_off_target = at.phase < target_until_ - 1e-9;
    for (const auto& link : links_) {
      const Eigen::Vector3d centre = at.kinematics.X_WB[link.shape->body] * link.shape->X_BG.translation();
      for (const auto& body : scene_.obstacles) visit(at, link, centre, body, f);
      if (keep_off_target || !link.shape->hand) visit(at, link, centre, scene_.target, f);
    }
  }

  template <class F>
  void visit(const Configuration& at, const Link& link, const Eigen::Vector3d& centre, const SceneBody& body,
             F&& f) const {
    const double reach = link.bounding_radius + margin_, far = reach + body.bounding_radius;
    const Eigen::Vector3d offset = centre - body.X_WB.translation();
    if (offset.squaredNorm() >= far * far) return;
    // The centre's distance to the body itself, not to its bounding sphere: a table is much flatter than that.
    Eigen::Vector3d normal;
    if (robot::signed_distance(body.shape, body.X_WB.linear().transpose() * offset, normal) >= reach) return;
    const auto d = robot::distance(link.shape->shape, robot_.pose(at.kinematics, *link.shape), body.shape, body.X_WB);
    if (d.distance < margin_) f(*link.shape, body, d);
  }

  const robot::Robot& robot_;
  const PlanningScene& scene_;
  const double margin_, target_until_;
  std::vector<Link> links_;
};

}  // namespace

TaskVariableEntry collision_task() {
  return {"collision",
          "summed proximity 1 − d/margin of links to obstacles, the table and, before target_until, the target",
          {{"margin", 0.04, 1e-4, 1, "m, the distance from which a pair counts"},
           {"target_until", 0.8, 0, 2, "phase until which the hand keeps off the target"}},
          [](const TaskSetup& setup) -> std::unique_ptr<TaskVariable> { return std::make_unique<Collision>(setup); }};
}

}  // namespace primo::motion

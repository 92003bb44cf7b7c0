// Collision: how much all links, and what the hand holds, together come too near to what they must not touch.
#include <algorithm>
#include <cmath>

#include "config/config.h"
#include "motion/task_frames.h"
#include "motion/task_variables.h"
#include "robot/distance.h"

namespace primo::motion {
namespace {

// m. A path bends by about half of that between two steps, and solvers keep constraints to a tenth of it.
constexpr double kClearance = 1e-3;

/// φ(q) = Σ max(0, 1 − d / margin) over pairs (1 row):
/// - a moving link and an obstacle or the table;
/// - the target and every link of the arm, and before phase `target_until` every link of the hand, which has to come
/// near
///   it in the end;
/// - the held object and every link of the arm, every obstacle and the table; when it is the target, its support (the
///   action's second argument) before `target_until` only. Hand and held object are no pair.
class Collision final : public TaskVariable {
 public:
  explicit Collision(const TaskSetup& setup)
      : robot_(setup.robot),
        scene_(setup.scene),
        margin_(setup.parameters.at("margin")),
        target_until_(setup.parameters.at("target_until")),
        departs_(setup.parameters.at("departs") > 0) {
    for (const auto& link : robot_.link_shapes()) {
      if (!link.moves) continue;
      movers_.push_back(
          {&link.name, &link.shape, {link.body, link.X_BG}, robot::bounding_radius(link.shape), link.hand});
    }
    if (!scene_.held) return;
    const auto held = find_object(robot_, scene_, "held").value();
    held_ = {&held.body->name, &held.body->shape, held.frame, held.body->bounding_radius, true};
    if (scene_.target_is_held()) support_ = scene_.contact();
  }
  int size() const override { return 1; }
  bool departs_from_start() const override { return departs_; }

  void evaluate(const Configuration& at, Eigen::Ref<Eigen::VectorXd> phi, Jacobian* J) const override {
    phi[0] = 0;
    if (J) J->setZero();
    for_each_near_pair(at, [&](const Mover& mover, const SceneBody&, int body, const robot::Distance& d) {
      phi[0] += 1 - d.distance / margin_;
      if (!J) return;
      robot_.add_point_gradient(at.kinematics, mover.frame.body, d.point_a, -d.gradient / margin_, J->row(0));
      if (body > 0) robot_.add_point_gradient(at.kinematics, body, d.point_a, d.gradient / margin_, J->row(0));
    });
  }

  int inequalities() const override { return static_cast<int>((movers_.size() + 1) * bodies()); }

  /// c = min(d, margin) − clearance for each pair: pairs that do not count at this phase are as far as the margin.
  void inequality(const Configuration& at, Eigen::Ref<Eigen::VectorXd> c, Jacobian* J) const override {
    const double clearance = std::min(kClearance, margin_ / 2);
    c.setConstant(margin_ - clearance);
    if (J) J->setZero();
    for_each_near_pair(at, [&](const Mover& mover, const SceneBody& other, int body, const robot::Distance& d) {
      const auto row = pair_number(mover, other);
      c[row] = d.distance - clearance;
      if (!J) return;
      robot_.add_point_gradient(at.kinematics, mover.frame.body, d.point_a, d.gradient, J->row(row));
      if (body > 0) robot_.add_point_gradient(at.kinematics, body, d.point_a, -d.gradient, J->row(row));
    });
  }

  std::string explain(const Configuration& at) const override {
    double nearest = margin_;
    std::string text;
    for_each_near_pair(at, [&](const Mover& mover, const SceneBody& other, int, const robot::Distance& d) {
      if (d.distance >= nearest) return;
      nearest = d.distance;
      text = *mover.name + " and " + other.name + " are " + config::detail::format(std::round(d.distance * 1e4) / 1e4) +
             " m apart";
    });
    return text;
  }

 private:
  /// A shape that the joints move.
  struct Mover {
    const std::string* name = nullptr;
    const Shape* shape = nullptr;
    robot::Frame frame;
    double bounding_radius = 0;
    bool hand = false;
  };

  /// The obstacles, the target and the held object.
  std::size_t bodies() const { return scene_.obstacles.size() + 2; }

  /// By mover, the held object last, then by body.
  Eigen::Index pair_number(const Mover& mover, const SceneBody& body) const {
    const auto first = static_cast<std::size_t>(&mover == &held_ ? movers_.size() : &mover - movers_.data());
    const std::size_t obstacles = scene_.obstacles.size();
    const bool is_held = scene_.held && &body == &*scene_.held;
    const auto second = is_held                   ? obstacles + 1
                        : &body == &scene_.target ? obstacles
                                                  : static_cast<std::size_t>(&body - scene_.obstacles.data());
    return static_cast<Eigen::Index>(first * bodies() + second);
  }

  /// Calls f(mover, body, moved_by, distance) for each pair within the margin; `moved_by` is the robot's body that
  /// moves the other body, 0 for none.
  template <class F>
  void for_each_near_pair(const Configuration& at, F&& f) const {
    const bool keep_off = at.phase < target_until_ - 1e-9;
    const bool held_target = scene_.target_is_held();
    const Pose X_WH = held_.name ? robot_.pose(at.kinematics, held_.frame) : Pose::Identity();
    for (const auto& mover : movers_) {
      Placed placed(at.kinematics, mover);
      for (const auto& body : scene_.obstacles) visit(placed, body, body.X_WB, 0, f);
      if (!held_target && (keep_off || !mover.hand)) visit(placed, scene_.target, scene_.target.X_WB, 0, f);
      if (held_.name && !mover.hand) visit(placed, *scene_.held, X_WH, held_.frame.body, f);
    }
    if (!held_.name) return;
    Placed placed(at.kinematics, held_);
    for (const auto& body : scene_.obstacles) {
      if (keep_off || &body != support_) visit(placed, body, body.X_WB, 0, f);
    }
    if (!held_target) visit(placed, scene_.target, scene_.target.X_WB, 0, f);
  }

  /// Where a mover is: its centre, and its pose for the few that are near something.
  class Placed {
   public:
    Placed(const robot::Kinematics& kinematics, const Mover& mover)
        : mover_(mover), X_WB_(kinematics.X_WB[mover.frame.body]) {
      centre_.noalias() = X_WB_.linear() * mover.frame.X_BF.translation();
      centre_ += X_WB_.translation();
    }
    const Mover& mover() const { return mover_; }
    const Eigen::Vector3d& centre() const { return centre_; }
    const Pose& X_WM() {
      if (!ready_) X_WM_ = X_WB_ * mover_.frame.X_BF;
      ready_ = true;
      return X_WM_;
    }

   private:
    const Mover& mover_;
    const Pose& X_WB_;
    Eigen::Vector3d centre_;
    Pose X_WM_;
    bool ready_ = false;
  };

  template <class F>
  void visit(Placed& placed, const SceneBody& body, const Pose& X_WB, int moved_by, F&& f) const {
    const Mover& mover = placed.mover();
    const double far = mover.bounding_radius + margin_ + body.bounding_radius;
    if ((placed.centre() - X_WB.translation()).squaredNorm() >= far * far) return;
    if (!robot::may_be_within(*mover.shape, placed.X_WM(), body.shape, X_WB, margin_)) return;
    const auto d = robot::distance(*mover.shape, placed.X_WM(), body.shape, X_WB);
    if (d.distance < margin_) f(mover, body, moved_by, d);
  }

  const robot::Robot& robot_;
  const PlanningScene& scene_;
  const double margin_, target_until_;
  const bool departs_;
  std::vector<Mover> movers_;
  Mover held_;                          // without a name: nothing is held
  const SceneBody* support_ = nullptr;  // of a held target
};

}  // namespace

TaskVariableEntry collision_task() {
  return {
      "collision",
      "summed proximity 1 − d/margin of links and the held object to obstacles, the table and, before target_until, "
      "the target or the held target's support",
      {{"margin", 0.04, 1e-4, 1, "m, the distance from which a pair counts"},
       {"target_until", 0.8, 0, 2, "phase until which the hand keeps off the target, a held target off its support"},
       {"departs", 1, 0, 1, "1: the target comes linearly from its value at the start, 0: it is y* at once"}},
      {},
      make_variable<Collision>};
}

}  // namespace primo::motion

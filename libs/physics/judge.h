// The judge: whether a planned motion does what its action promises. A pure function of the request.
//
// Mode::final_pose follows the paper (Sec. V): the hand and the object are put into the final pose, the fingers close
// on the held object, the object is let go, and the hand is shaken with a band-limited Brownian motion. Only hand and
// object are simulated, in the frame of the hand, with the exact forces of that accelerated frame. Mode::execute runs
// the whole motion in full physics instead, then closes, lifts and holds. In both, success is strict: the path itself
// must also be clean (see criteria.h).
#pragma once

#include <memory>

#include "core/result.h"
#include "physics/recording.h"
#include "physics/verdict.h"
#include "robot/robot.h"

namespace primo::physics {

class Judge {
 public:
  explicit Judge(robot::Robot robot);
  ~Judge();
  Judge(Judge&&) noexcept;
  Judge& operator=(Judge&&) noexcept;

  /// Same request, same verdict, bit for bit, in any order and from any number of threads at once.
  /// Error (Code::data): a malformed request: wrong sizes, numbers that are not finite, an unknown action or object, a
  /// scenario that is not valid. A well-formed plan that is merely bad gets a verdict. Error (Code::config): MuJoCo
  /// refuses the robot's model.
  /// `recording`, where there is one, gets the states of an execution; it does not change the verdict.
  Result<Verdict> evaluate(const JudgeRequest& request, Recording* recording = nullptr) const;

  const robot::Robot& robot() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace primo::physics

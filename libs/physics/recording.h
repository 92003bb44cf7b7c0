// States of an executed motion at even times, for pictures.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"

namespace primo::physics {

struct Recording {
  struct Frame {
    double time = 0;         ///< s
    Eigen::VectorXd q;       ///< rad, the robot file's joint order
    std::vector<Pose> X_WO;  ///< of the scenario's objects, in its order
  };
  double interval = 0.04;  ///< s between frames
  std::vector<Frame> frames;
};

}  // namespace primo::physics

// A motion as an MP4 film, without a display: frames rendered in software, encoded by Debian's ffmpeg as a child
// process.
#pragma once

#include "physics/picture.h"
#include "physics/recording.h"

namespace primo::physics {

struct MovieOptions {
  PictureOptions picture;    ///< width and height even; close_hand is not used
  double frame_rate = 25;    ///< Hz
  double still_seconds = 1;  ///< of the last state at the end
  bool dashed = false;
  const Eigen::MatrixXd* compare = nullptr;  ///< as in MotionPictureOptions
};

/// The plan q (rows, dt s apart) as it is, nothing else moving but what the hand holds: what the final-pose verdict
/// takes for granted.
Recording replay(const robot::Robot& robot, const Eigen::MatrixXd& q, double dt, const scene::Scenario& scenario,
                 double interval);

/// The frames of `recording` as H.264 in an MP4 file, never half-written, with the path of the grasp centre over q.
/// Same input, same bytes, with the same version of ffmpeg. Errors: a size that is odd or out of range; no or more than
/// 5000 frames; ffmpeg missing (unavailable) or failing; what render_png() refuses.
Status render_movie(const std::filesystem::path& path, const robot::Robot& robot, const scene::Scenario& scenario,
                    const Eigen::MatrixXd& q, const Recording& recording, const MovieOptions& options = {});

}  // namespace primo::physics

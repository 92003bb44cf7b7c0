// camera: renders a scenario's depth images. Answers camera jobs and shows each cloud as a ROS 2 PointCloud2.
#include <primo_jobs.h>

#include "bus/latched.h"
#include "core/rate_limit.h"
#include "physics/depth_camera.h"
#include "service/service.h"
#include "wire/wire.h"

namespace primo {
namespace {

struct CameraConfig {
  double range = 4.0;
  double show_rate = 5;
  template <class V>
  void visit(V&& v) {
    v("range", range, {.help = "of the cameras", .unit = "m", .min = 0.1, .max = 100});
    v("show_rate", show_rate,
      {.help = "scenes shown on rt/points at most, frames camera_0, camera_1, …; 0: none",
       .unit = "Hz",
       .min = 0,
       .max = 1000});
  }
};

Status run(const CameraConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto points,
               bus::Publisher<sensor_msgs::msg::PointCloud2>::create(context.participant(), topics::kPoints));
  RateLimit shows(config.show_rate);
  return context.serve(topics::kCamera, [&](const topics::msg::CameraJob& job) -> Result<topics::msg::CameraReply> {
    PRIMO_ASSIGN(const scene::Scenario scenario, wire::from_wire(job.scenario()));
    PRIMO_ASSIGN(const auto clouds, physics::render_depth(scenario, {config.range, job.lowest()}));
    topics::msg::CameraReply reply;
    const bool show = points.matched() > 0 && shows.due();
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      reply.clouds().push_back(wire::to_wire(clouds[i]));
      // For onlookers only; the job does not depend on them.
      if (show) {
        if (const auto shown = points.publish(wire::to_ros(clouds[i], "camera_" + std::to_string(i))); !shown.ok()) {
          context.log().warn("a cloud was not shown: {}", shown.error().message);
        }
      }
    }
    return reply;
  });
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) { return primo::service::run<primo::CameraConfig>("camera", argc, argv, primo::run); }

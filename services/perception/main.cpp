// perception: from depth images to objects, table and occupancy map. Answers perception jobs, and follows a robot's own
// camera on rt/points: clouds whose frame is the configured live frame, which is the world's. Every scene is latched on
// the topic scene.
#include <primo_jobs.h>

#include <mutex>
#include <optional>
#include <thread>

#include "bus/latched.h"
#include "scene/perception.h"
#include "service/service.h"
#include "wire/wire.h"

namespace primo {
namespace {

using sensor_msgs::msg::PointCloud2;

struct PerceptionConfig {
  scene::PerceptionSettings perception;
  std::string live_frame = "world";
  template <class V>
  void visit(V&& v) {
    v("perception", perception, {});
    v("live_frame", live_frame, {.help = "clouds on rt/points with this frame are scenes too; empty: none are"});
  }
};

/// The newest live cloud, perceived on a thread of its own so that jobs do not wait for it.
class Live {
 public:
  using Perceive = std::function<void(const PointCloud2&)>;
  explicit Live(Perceive perceive)
      : thread_([this, perceive = std::move(perceive)](const std::stop_token& stop) { run(stop, perceive); }) {}
  void put(PointCloud2&& cloud) {
    {
      const std::lock_guard lock(mutex_);
      newest_ = std::move(cloud);
    }
    changed_.notify_one();
  }

 private:
  void run(const std::stop_token& stop, const Perceive& perceive) {
    while (!stop.stop_requested()) {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return newest_.has_value(); })) return;
      const PointCloud2 cloud = std::move(*newest_);
      newest_.reset();
      lock.unlock();
      perceive(cloud);
    }
  }
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<PointCloud2> newest_;
  std::jthread thread_;  // last: stops before the rest goes
};

Status run(const PerceptionConfig& config, service::Context& context) {
  PRIMO_ASSIGN(auto scenes, bus::Publisher<topics::msg::SceneEstimate>::create(context.participant(), topics::kScene));
  std::mutex publishing;
  const auto publish = [&](const topics::msg::SceneEstimate& estimate) {
    const std::lock_guard lock(publishing);
    if (const auto status = scenes.publish(estimate); !status.ok())
      context.log().warn("a scene was not published: {}", status.error().message);
  };

  Live live([&](const PointCloud2& message) {
    const auto cloud = wire::from_ros(message);
    auto estimate =
        cloud.ok() ? scene::perceive({*cloud}, config.perception) : Result<scene::SceneEstimate>(cloud.error());
    if (estimate.ok()) {
      publish(wire::to_wire(*estimate));
    } else {
      context.status().set_error("a cloud on rt/points: " + estimate.error().message);
    }
  });
  const auto on_cloud = [&](PointCloud2&& cloud) {
    if (!config.live_frame.empty() && cloud.header().frame_id() == config.live_frame) live.put(std::move(cloud));
  };
  PRIMO_ASSIGN(const auto points,
               bus::Subscription<PointCloud2>::create(context.participant(), topics::kPoints, on_cloud));

  return context.serve(topics::kPerception,
                       [&](const topics::msg::PerceptionJob& job) -> Result<topics::msg::PerceptionReply> {
                         PRIMO_ASSIGN(const scene::Scenario scenario, wire::from_wire(job.scenario()));
                         std::vector<scene::PointCloud> clouds;
                         for (const auto& message : job.clouds()) {
                           PRIMO_ASSIGN(auto cloud, wire::from_wire(message));
                           clouds.push_back(std::move(cloud));
                         }
                         auto request = scene::perception_request(scenario, std::move(clouds), config.perception);
                         request.octree = job.octree();
                         PRIMO_ASSIGN(const auto estimate, scene::perceive(request));
                         topics::msg::PerceptionReply reply;
                         reply.estimate(wire::to_wire(estimate));
                         publish(reply.estimate());
                         return reply;
                       });
}

}  // namespace
}  // namespace primo

int main(int argc, char** argv) {
  return primo::service::run<primo::PerceptionConfig>("perception", argc, argv, primo::run);
}

#include "physics/movie.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "core/files.h"
#include "physics/canvas.h"
#include "scene/held.h"

extern char** environ;

namespace primo::physics {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFrames = 5000;

/// ffmpeg as a child that reads raw frames. One thread and no dates: the same frames give the same file.
class Encoder {
 public:
  static Result<Encoder> start(const fs::path& output, int width, int height, double rate) {
    // A socket, not a pipe: writing to a child that is gone must be an error and not a signal.
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      return Error{Code::internal, std::string("no socket for ffmpeg: ") + std::strerror(errno)};
    std::vector<std::string> words = {"ffmpeg",
                                      "-loglevel",
                                      "error",
                                      "-f",
                                      "rawvideo",
                                      "-pix_fmt",
                                      "rgb24",
                                      "-s",
                                      std::to_string(width) + "x" + std::to_string(height),
                                      "-r",
                                      number(rate),
                                      "-i",
                                      "pipe:0",
                                      "-c:v",
                                      "libx264",
                                      "-threads",
                                      "1",
                                      "-crf",
                                      "20",
                                      "-pix_fmt",
                                      "yuv420p",
                                      "-fflags",
                                      "+bitexact",
                                      "-flags:v",
                                      "+bitexact",
                                      "-map_metadata",
                                      "-1",
                                      "-movflags",
                                      "+faststart",
                                      "-f",
                                      "mp4",
                                      "-y",
                                      output.string()};
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (auto& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child = -1;
    const int failed = posix_spawnp(&child, "ffmpeg", &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[0]);
    if (failed == 0) return Encoder(child, ends[1]);
    close(ends[1]);
    return Error{Code::unavailable,
                 std::string("a film needs the program ffmpeg, of Debian's package ffmpeg: ") + std::strerror(failed)};
  }

  Encoder(Encoder&& other) noexcept
      : child_(std::exchange(other.child_, -1)), socket_(std::exchange(other.socket_, -1)) {}
  Encoder& operator=(Encoder&&) = delete;
  ~Encoder() { finish(); }

  /// False when ffmpeg takes no more.
  bool write(const Image& image) {
    const auto* at = image.rgb.data();
    for (std::size_t left = image.rgb.size(); left > 0;) {
      const ssize_t sent = send(socket_, at, left, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) return false;
      at += sent;
      left -= static_cast<std::size_t>(sent);
    }
    return true;
  }

  /// Ends the film; the child's exit code.
  int finish() {
    if (socket_ >= 0) close(std::exchange(socket_, -1));
    if (child_ < 0) return code_;
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }

 private:
  Encoder(pid_t child, int socket) : child_(child), socket_(socket) {}
  static std::string number(double value) { return numbers(&value, 1); }

  pid_t child_ = -1;
  int socket_ = -1;
  int code_ = -1;
};

Status check(const robot::Robot& robot, const scene::Scenario& scenario, const Recording& recording,
             const MovieOptions& options) {
  if (options.picture.width % 2 != 0 || options.picture.height % 2 != 0)
    return Error{Code::usage, "a film's width and height must be even"};
  if (!(options.frame_rate >= 1 && options.frame_rate <= 120) ||
      !(options.still_seconds >= 0 && options.still_seconds <= 10))
    return Error{Code::usage, "a film has 1 … 120 frames a second and stands still for 0 … 10 s at its end"};
  if (recording.frames.empty() || recording.frames.size() > kMostFrames) {
    return Error{Code::data, "a film has 1 … " + std::to_string(kMostFrames) + " frames, not " +
                                 std::to_string(recording.frames.size())};
  }
  for (const auto& frame : recording.frames) {
    if (frame.q.size() != robot.joints() || !frame.q.allFinite() || frame.X_WO.size() != scenario.objects.size())
      return Error{Code::data,
                   "a frame of the film is not of robot " + robot.name() + " and scenario " + scenario.name};
  }
  return success();
}

/// Renders the frames into the encoder.
Status encode(Encoder& encoder, Canvas& canvas, const scene::Scenario& scenario, const Eigen::MatrixXd& q,
              const Recording& recording, const MovieOptions& options) {
  const Error gone{Code::failed, "ffmpeg ended before the film did"};
  const View view = options.picture.view.value_or(overview(scenario));
  Image image;
  for (const auto& frame : recording.frames) {
    for (std::size_t i = 0; i < scenario.objects.size(); ++i)
      canvas.pose_object(scenario.objects[i].name, frame.X_WO[i]);
    canvas.pose_robot(frame.q);
    canvas.draw_all();
    canvas.draw_path(q, options.dashed);
    if (options.compare) canvas.draw_path(*options.compare, !options.dashed, kOtherLine);
    PRIMO_ASSIGN(image, canvas.image(view));
    if (!encoder.write(image)) return gone;
  }
  for (int k = static_cast<int>(std::lround(options.still_seconds * options.frame_rate)); k > 0; --k) {
    if (!encoder.write(image)) return gone;
  }
  return success();
}

}  // namespace

Recording replay(const robot::Robot& robot, const Eigen::MatrixXd& q, double dt, const scene::Scenario& scenario,
                 double interval) {
  Recording recording;
  recording.interval = interval;
  std::vector<Pose> objects;
  for (const auto& object : scenario.objects) objects.push_back(object.X_WO());
  const double last = static_cast<double>(q.rows() - 1);
  const int frames = static_cast<int>(std::min(last * dt / interval, 1e6));
  for (int k = 0; k <= frames; ++k) {
    const double at = std::min(k * interval / dt, last);
    const auto t = std::min(static_cast<Eigen::Index>(at), std::max<Eigen::Index>(q.rows() - 2, 0));
    const Eigen::Index next = std::min(t + 1, q.rows() - 1);
    const double s = at - static_cast<double>(t);
    Recording::Frame frame{k * interval, ((1 - s) * q.row(t) + s * q.row(next)).transpose(), objects};
    if (scenario.held) {
      frame.q = scene::with_held_fingers(scenario, robot, std::move(frame.q));
      const auto held = std::find_if(scenario.objects.begin(), scenario.objects.end(),
                                     [&](const auto& object) { return scenario.holds(object.name); });
      frame.X_WO[static_cast<std::size_t>(held - scenario.objects.begin())] =
          scene::held_pose(scenario, robot, frame.q);
    }
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

Status render_movie(const fs::path& path, const robot::Robot& robot, const scene::Scenario& scenario,
                    const Eigen::MatrixXd& q, const Recording& recording, const MovieOptions& options) {
  PRIMO_TRY(check(robot, scenario, recording, options));
  auto canvas =
      Canvas::create(&robot, scenario, options.picture, {.supersampling = 1, .shadows = 1024, .reflections = false});
  if (!canvas.ok()) return canvas.error();
  fs::path unfinished = path;
  unfinished += ".part";
  auto encoder = Encoder::start(unfinished, options.picture.width, options.picture.height, options.frame_rate);
  if (!encoder.ok()) return encoder.error();
  Status status = encode(*encoder, *canvas, scenario, q, recording, options);
  const int code = encoder->finish();
  if (status.ok() && code != 0)
    status = Error{Code::failed, path.string() + ": ffmpeg failed with exit code " + std::to_string(code)};
  std::error_code ec;
  if (status.ok()) {
    fs::rename(unfinished, path, ec);
    if (ec) status = Error{Code::config, path.string() + ": cannot be written: " + ec.message()};
  }
  if (!status.ok()) fs::remove(unfinished, ec);
  return status;
}

}  // namespace primo::physics

#include "primo/graph/supervisor.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "bus/shared_memory.h"
#include "core/files.h"

namespace primo::tool {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

std::vector<std::string> child_environment(const Layout& layout) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view text = *entry;
    if (!text.starts_with("PRIMO_")) environment.emplace_back(text);
  }
  environment.push_back("PRIMO_BIN=" + layout.bin.string());
  environment.push_back("PRIMO_SERVICES=" + layout.services.string());
  environment.push_back("PRIMO_RUN=" + layout.run.string());
  environment.push_back("PRIMO_ROBOT=" + layout.robot.string());
  environment.push_back("PRIMO_DOMAIN=" + std::to_string(layout.domain));
  return environment;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

struct Finished {
  int exit = -1;
  std::string output;
};

/// Runs a program to its end; its standard output and error come back together.
Result<Finished> run_program(std::vector<std::string> arguments, std::vector<std::string> environment) {
  int pipe_ends[2];
  if (::pipe2(pipe_ends, O_CLOEXEC) != 0) return Error{Code::internal, std::string("pipe: ") + std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDERR_FILENO);
  const auto argv = pointers(arguments);
  const auto envp = pointers(environment);
  pid_t pid = 0;
  const int failed = ::posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe_ends[1]);
  if (failed != 0) {
    ::close(pipe_ends[0]);
    return Error{Code::unavailable, arguments[0] + " cannot be started: " + std::strerror(failed)};
  }
  Finished finished;
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(pipe_ends[0], buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    finished.output.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(pipe_ends[0]);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  finished.exit = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  while (!finished.output.empty() && finished.output.back() == '\n') finished.output.pop_back();
  return finished;
}

/// The configuration with this run-time folder and number of workers in place of the default ones.
Result<fs::path> render_configuration(const Layout& layout, int workers) {
  const fs::path source = layout.root / "compose" / "supervisord.conf";
  PRIMO_ASSIGN(std::string text, read_file(source));
  replace_all(text, "%(here)s/../.primo", layout.run.string());
  replace_all(text, "%(here)s", source.parent_path().string());
  replace_all(text, "numprocs=" + std::to_string(kWorkers), "numprocs=" + std::to_string(workers));
  const fs::path target = layout.run / "supervisord.conf";
  PRIMO_TRY(write_file(target, text));
  return target;
}

bool wait_until_gone(pid_t pid, double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (::kill(pid, 0) == 0 && Clock::now() < end) {
    // A zombie (a child of ours, or of an init that does not reap) is as good as gone.
    const std::string stat = slurp("/proc/" + std::to_string(pid) + "/stat");
    if (const auto at = stat.rfind(')'); at != std::string::npos && stat.substr(at, 3) == ") Z") return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return ::kill(pid, 0) != 0;
}

}  // namespace

std::vector<Expected> expected_workers(int workers) {
  return {{"camera"},       {"perception"}, {"planner", workers}, {"judge", workers},
          {"rule_learner"}, {"optimizer"},  {"conductor"}};
}

std::optional<pid_t> supervisor_pid(const Layout& layout) {
  const std::string text = slurp(layout.run / "supervisord.pid");
  pid_t pid = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), pid).ec != std::errc() || pid <= 1) return std::nullopt;
  // Another process may have the number by now.
  const std::string command = slurp("/proc/" + std::to_string(pid) + "/cmdline");
  if (command.find("supervisord") == std::string::npos) return std::nullopt;
  if (command.find((layout.run / "supervisord.conf").string()) == std::string::npos &&
      command.find("compose/supervisord.conf") == std::string::npos) {
    return std::nullopt;
  }
  return pid;
}

std::vector<pid_t> graph_processes(const Layout& layout) {
  const std::string mark = "PRIMO_RUN=" + layout.run.string();
  std::vector<pid_t> result;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator("/proc", ec)) {
    const std::string name = entry.path().filename();
    pid_t pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ec != std::errc()) continue;
    const fs::path program = fs::read_symlink(entry.path() / "exe", ec);
    if (ec || !program.filename().string().starts_with("primo_")) continue;
    const std::string environment = slurp(entry.path() / "environ");
    if (environment.starts_with(mark + '\0') || environment.find('\0' + mark + '\0') != std::string::npos)
      result.push_back(pid);
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::string process_role(pid_t pid) {
  std::error_code ec;
  const std::string name = fs::read_symlink("/proc/" + std::to_string(pid) + "/exe", ec).filename();
  return name.starts_with("primo_") ? name.substr(6) : "";
}

Status check_services(const Layout& layout) {
  for (const auto& [role, count] : expected_workers()) {
    const std::string launch = (layout.root / "compose" / "launch").string();
    PRIMO_ASSIGN(const Finished finished, run_program({launch, role, "--check-config"}, child_environment(layout)));
    if (finished.exit != 0) {
      const auto line = finished.output.substr(finished.output.rfind('\n') + 1);
      return Error{finished.exit == 69 ? Code::unavailable : Code::config, role + ": " + line};
    }
  }
  return success();
}

Status start_supervisor(const Layout& layout, int workers, bool foreground) {
  if ((layout.run / "supervisor.sock").string().size() > 90) {
    return Error{Code::config,
                 layout.run.string() +
                     ": too long for the run-time folder: the name of a socket in it may have at most 107 characters. "
                     "Choose a shorter one with --run"};
  }
  PRIMO_TRY(remember_graph(layout));
  PRIMO_ASSIGN(const fs::path configuration, render_configuration(layout, workers));
  std::vector<std::string> arguments = {"supervisord", "-c", configuration.string()};
  auto environment = child_environment(layout);
  if (foreground) {
    arguments.insert(arguments.begin() + 1, "-n");
    const auto argv = pointers(arguments);
    const auto envp = pointers(environment);
    ::execvpe(argv[0], argv.data(), envp.data());
    return Error{Code::unavailable, std::string("supervisord cannot be started: ") + std::strerror(errno) +
                                        ". Is the package supervisor installed?"};
  }
  const auto started = run_program(arguments, environment);
  if (!started.ok())
    return Error{Code::unavailable, started.error().message + ". Is the package supervisor installed?"};
  if (started->exit != 0) {
    return Error{Code::unavailable, "supervisord ended with " + std::to_string(started->exit) + ": " +
                                        started->output.substr(started->output.rfind('\n') + 1)};
  }
  // The daemon writes its number a little after its parent has ended.
  const auto end = Clock::now() + std::chrono::seconds(5);
  while (!supervisor_pid(layout) && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  if (!supervisor_pid(layout)) {
    return Error{Code::unavailable,
                 "supervisord did not come up; " + (layout.run / "supervisord.log").string() + " says why"};
  }
  return success();
}

Status stop_graph(const Layout& layout) {
  if (const auto pid = supervisor_pid(layout)) {
    ::kill(*pid, SIGTERM);
    if (!wait_until_gone(*pid, 20)) ::kill(*pid, SIGKILL);
  }
  // What a killed supervisord left behind.
  for (const int sign : {SIGTERM, SIGKILL}) {
    const auto rest = graph_processes(layout);
    for (const pid_t pid : rest) ::kill(pid, sign);
    for (const pid_t pid : rest) wait_until_gone(pid, 5);
  }
  const auto rest = graph_processes(layout);
  if (!rest.empty())
    return Error{Code::failed, "process " + std::to_string(rest.front()) + " does not end, even killed"};
  std::error_code ec;
  for (const char* name : {"supervisor.sock", "supervisord.pid", "supervisord.conf", "domain"})
    fs::remove(layout.run / name, ec);
  bus::remove_dead_shared_memory();
  return success();
}

}  // namespace primo::tool

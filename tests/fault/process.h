// A process started by a test, ended at the latest with it.
#pragma once

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "../test_domain.h"

namespace primo {

class Process {
 public:
  /// Starts the test worker with these arguments; its output is kept. `before` runs in the child.
  explicit Process(const std::vector<std::string>& arguments, const std::function<void()>& before = {}) {
    char name[] = "/tmp/primo_test_XXXXXX";
    const int file = mkstemp(name);
    output_ = name;
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(127);
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
      if (before) before();
      std::vector<char*> argv = {const_cast<char*>(PRIMO_TEST_WORKER)};
      for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
      argv.push_back(nullptr);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(file);
  }
  Process(Process&& other) noexcept
      : pid_(std::exchange(other.pid_, -1)), status_(other.status_), output_(std::exchange(other.output_, "")) {}
  Process& operator=(Process&&) = delete;
  ~Process() {
    if (pid_ > 0) {
      kill(pid_, SIGCONT);
      kill(pid_, SIGTERM);
      if (wait(std::chrono::seconds(3)) < 0) {
        kill(pid_, SIGKILL);
        waitpid(pid_, &status_, 0);
      }
    }
    if (!output_.empty()) std::remove(output_.c_str());
  }

  pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }
  std::string output() const {
    std::ifstream file(output_);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  /// The exit code; 128 + the signal's number after a signal; -1 when it still runs after the time.
  int wait(std::chrono::milliseconds timeout = std::chrono::seconds(20)) {
    const auto until = std::chrono::steady_clock::now() + timeout;
    while (std::chrono::steady_clock::now() < until) {
      if (waitpid(pid_, &status_, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return -1;
  }
  /// The files of Fast DDS's shared memory that this process has mapped.
  std::set<std::string> shared_memory() const {
    std::ifstream maps("/proc/" + std::to_string(pid_) + "/maps");
    std::set<std::string> names;
    for (std::string line; std::getline(maps, line);) {
      const auto at = line.find("/dev/shm/fastrtps_");
      if (at != std::string::npos) names.insert(line.substr(at));
    }
    return names;
  }
  /// Of these only what this process has made: its segments, not the ports, which are shared.
  std::set<std::string> segments() const {
    auto names = shared_memory();
    std::erase_if(names, [](const std::string& name) { return name.find("port") != std::string::npos; });
    return names;
  }

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  std::string output_;
};

/// A worker named so, in this test's domain.
inline Process start_worker(const std::string& name) {
  return Process({"--name", name, "--domain", std::to_string(test_domain()), "--set", "service.bus.segment_mib=4"});
}

}  // namespace primo

#include "core/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace primo {

Result<Finished> run_program(const std::vector<std::string>& words, const std::filesystem::path& directory) {
  PRIMO_CHECK(!words.empty(), "a program has a name");
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    return Error{Code::internal, "no pipe for " + words[0] + ": " + std::strerror(errno)};
  auto owned = words;
  std::vector<char*> argv;
  argv.reserve(owned.size() + 1);
  for (auto& word : owned) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  if (!directory.empty()) posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  pid_t child = -1;
  const int failed = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (failed != 0) {
    close(ends[0]);
    return Error{Code::unavailable, "the program " + words[0] + " cannot be run: " + std::strerror(failed)};
  }
  Finished finished;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(ends[0], buffer.data(), buffer.size())) != 0;) {
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) break;
    const std::size_t room = Finished::kMostOutput - finished.output.size();
    finished.output.append(buffer.data(), std::min(room, static_cast<std::size_t>(n)));
  }
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  finished.exit = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return finished;
}

}  // namespace primo

#include "bus/shared_memory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace primo::bus {

Status probe_shared_memory(std::size_t bytes) {
  static std::atomic<unsigned> count{0};
  const std::string name = "/primo_probe_" + std::to_string(getpid()) + "_" + std::to_string(count++);
  const std::string remedy = "; make room in /dev/shm, or set bus.segment_mib lower or bus.shared_memory: false";
  const int file = shm_open(name.c_str(), O_CREAT | O_EXCL | O_RDWR, 0600);
  if (file < 0) {
    return Error{Code::unavailable,
                 std::string("bus: cannot create shared memory in /dev/shm: ") + std::strerror(errno) + remedy};
  }
  shm_unlink(name.c_str());
  const int error = posix_fallocate(file, 0, static_cast<off_t>(bytes));
  close(file);
  if (error != 0) {
    return Error{Code::unavailable, "bus: cannot have " + std::to_string(bytes >> 20) +
                                        " MiB of shared memory in /dev/shm: " + std::strerror(error) + remedy};
  }
  return success();
}

bool shared_memory_mapped() {
  std::ifstream maps("/proc/self/maps");
  if (!maps) return true;
  for (std::string line; std::getline(maps, line);) {
    if (line.find("/dev/shm/fastrtps_") != std::string::npos) return true;
  }
  return false;
}

namespace {

// RTPS 2.2, 9.6.1.1: PB + DG · domain + d1 or d3 + PG · participant.
int discovery_port(int domain, int participant) { return 7400 + 250 * domain + 10 + 2 * participant; }
int data_port(int domain, int participant) { return 7400 + 250 * domain + 11 + 2 * participant; }
std::string port_file(int port) { return "/dev/shm/fastrtps_port" + std::to_string(port); }

/// The ports that any process has mapped whose maps can be read.
std::set<std::string> mapped_ports() {
  namespace fs = std::filesystem;
  std::set<std::string> ports;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator("/proc", ec)) {
    const std::string process = entry.path().filename();
    if (process.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream maps(entry.path() / "maps");
    for (std::string line; std::getline(maps, line);) {
      const auto at = line.find("/dev/shm/fastrtps_port");
      if (at != std::string::npos) ports.insert(line.substr(at + 9, line.find(' ', at) - at - 9));
    }
  }
  return ports;
}

/// A segment or port NAME has a file NAME_el (or NAME_sl) that is locked as long as somebody listens there. A port
/// whose listener died may have lost that file and is then found by its name alone.
std::array<std::string, 4> files_of(const std::string& name) {
  return {name, name + "_el", name + "_sl", "sem." + name + "_mutex"};
}

const std::filesystem::path kFolder = "/dev/shm";

bool is_locked(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return errno != ENOENT;
  const bool locked = ::flock(fd, LOCK_EX | LOCK_NB) != 0;
  ::close(fd);
  return locked;
}

struct Leftovers {
  std::vector<std::string> dead;  // nobody has locked them, nobody has mapped those that are ports
  bool young = false;             // whether there are others, made too short a time ago to tell
};

Leftovers leftovers(std::chrono::seconds age) {
  namespace fs = std::filesystem;
  static const std::regex kFile("(fastrtps_(?:[0-9a-f]{16}|port[0-9]{1,5}))(_[es]l)?");
  std::map<std::string, bool> young;
  std::error_code ec;
  const auto latest = fs::file_time_type::clock::now() - age;
  for (const auto& entry : fs::directory_iterator(kFolder, ec)) {
    const std::string name = entry.path().filename();
    std::smatch match;
    if (!std::regex_match(name, match, kFile)) continue;
    const bool is_port = name.find("port") != std::string::npos;
    // A segment without the file that says whether it is locked is not ours to judge.
    if (!is_port && !match[2].matched) continue;
    young[match[1]] |= entry.last_write_time(ec) > latest;
  }
  // Only after the list: what is on it has been mapped by who made it, or never will be.
  const std::set<std::string> mapped = mapped_ports();
  Leftovers found;
  for (const auto& [name, is_young] : young) {
    if (mapped.contains(name)) continue;
    // A lock is tried only where nobody can be about to take it.
    if (is_young) {
      found.young = true;
    } else if (!is_locked(kFolder / (name + "_el")) && !is_locked(kFolder / (name + "_sl"))) {
      found.dead.push_back(name);
    }
  }
  return found;
}

int remove_all(const std::vector<std::string>& names) {
  std::error_code ec;
  for (const std::string& name : names) {
    for (const std::string& file : files_of(name)) std::filesystem::remove(kFolder / file, ec);
  }
  return static_cast<int>(names.size());
}

}  // namespace

int unused_participant_id(int domain, int count) {
  const auto has_file = [](int port) {
    const std::string name = port_file(port);
    return access(name.c_str(), F_OK) == 0 || access((name + "_el").c_str(), F_OK) == 0;
  };
  // Processes that start together begin to look at different places.
  std::uint32_t bits = 0;
  if (getrandom(&bits, sizeof bits, 0) != static_cast<ssize_t>(sizeof bits))
    bits = static_cast<std::uint32_t>(getpid());
  for (int i = 0; i < count; ++i) {
    const int id = static_cast<int>((bits + static_cast<std::uint32_t>(i)) % static_cast<std::uint32_t>(count));
    if (!has_file(discovery_port(domain, id)) && !has_file(data_port(domain, id))) return id;
  }
  return -1;
}

int remove_dead_shared_memory() {
  // What was made within the last second may be just about to be mapped and locked: it is looked at again after that.
  constexpr std::chrono::seconds kSettled{1};
  const Leftovers found = leftovers(kSettled);
  int removed = remove_all(found.dead);
  if (found.young) {
    std::this_thread::sleep_for(kSettled);
    removed += remove_all(leftovers(kSettled).dead);
  }
  return removed;
}

}  // namespace primo::bus

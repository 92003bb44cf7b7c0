#include "bus/shared_memory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>

namespace primo::bus {
namespace {

/// Whether a line of this process's memory map is wanted; true where that cannot be told.
template <class Wanted>
bool any_mapping(const Wanted& wanted) {
  std::ifstream maps("/proc/self/maps");
  if (!maps) return true;
  for (std::string line; std::getline(maps, line);) {
    if (wanted(line)) return true;
  }
  return false;
}

}  // namespace

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
  return any_mapping([](const std::string& line) { return line.find("/dev/shm/fastrtps_") != std::string::npos; });
}

namespace {

// RTPS 2.2, 9.6.1.1: PB + DG · domain + d1 or d3 + PG · participant.
int discovery_port(int domain, int participant) { return 7400 + 250 * domain + 10 + 2 * participant; }
int data_port(int domain, int participant) { return 7400 + 250 * domain + 11 + 2 * participant; }
std::string port_file(int port) { return "/dev/shm/fastrtps_port" + std::to_string(port); }

std::optional<ino_t> inode_of(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return status.st_ino;
}

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

OwnPorts::OwnPorts(int domain, int participant_id) {
  if (participant_id < 0) return;
  for (const int port : {discovery_port(domain, participant_id), data_port(domain, participant_id)}) {
    if (const auto inode = inode_of(port_file(port))) files_.emplace_back(port_file(port), *inode);
  }
}

bool OwnPorts::lost() const {
  return std::any_of(files_.begin(), files_.end(), [](const auto& known) {
    const auto inode = inode_of(known.first);
    if (inode == known.second) return false;
    // Fast DDS itself may have made the port anew, and has the new file mapped then; behind a deleted one stands so.
    return !inode || !any_mapping([&](const std::string& line) { return line.ends_with(known.first); });
  });
}

int remove_dead_shared_memory() {
  namespace fs = std::filesystem;
  // A segment or port NAME has a file NAME_el (or NAME_sl) that is locked as long as somebody listens there. A port
  // whose listener died may have lost that file and is then found by its name alone.
  static const std::regex kLock("(fastrtps_(?:[0-9a-f]{16}|port[0-9]{1,5}))_[es]l"), kPort("fastrtps_port[0-9]{1,5}");
  const fs::path folder = "/dev/shm";
  std::map<std::string, bool> in_use;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator(folder, ec)) {
    const std::string name = entry.path().filename();
    std::smatch match;
    if (std::regex_match(name, kPort)) in_use[name] |= false;
    if (!std::regex_match(name, match, kLock)) continue;
    const int fd = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
    in_use[match[1]] |= fd < 0 || ::flock(fd, LOCK_EX | LOCK_NB) != 0;
    if (fd >= 0) ::close(fd);
  }
  const std::set<std::string> mapped = mapped_ports();
  int removed = 0;
  for (const auto& [name, used] : in_use) {
    if (used || mapped.contains(name)) continue;
    for (const auto& file : {name, name + "_el", name + "_sl", "sem." + name + "_mutex"}) fs::remove(folder / file, ec);
    ++removed;
  }
  return removed;
}

}  // namespace primo::bus

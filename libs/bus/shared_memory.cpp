#include "bus/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

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
  if (!maps) return true;  // cannot be told
  for (std::string line; std::getline(maps, line);) {
    if (line.find("/dev/shm/fastrtps_") != std::string::npos) return true;
  }
  return false;
}

int unused_participant_id(int domain, int count) {
  // RTPS 2.2, 9.6.1.1: PB + DG · domain + d1 (metatraffic) or d3 (user data) + PG · participant.
  const int base = 7400 + 250 * domain;
  const auto has_file = [](int port) {
    const std::string name = "/dev/shm/fastrtps_port" + std::to_string(port);
    return access(name.c_str(), F_OK) == 0 || access((name + "_el").c_str(), F_OK) == 0;
  };
  // Processes that start together begin to look at different places.
  std::uint32_t bits = 0;
  if (getrandom(&bits, sizeof bits, 0) != static_cast<ssize_t>(sizeof bits))
    bits = static_cast<std::uint32_t>(getpid());
  for (int i = 0; i < count; ++i) {
    const int id = static_cast<int>((bits + static_cast<std::uint32_t>(i)) % static_cast<std::uint32_t>(count));
    if (!has_file(base + 10 + 2 * id) && !has_file(base + 11 + 2 * id)) return id;
  }
  return -1;
}

}  // namespace primo::bus

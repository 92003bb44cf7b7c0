#include "bus/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
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

}  // namespace primo::bus

#include "bus/orphaned_ports.h"

#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace primo::bus {
namespace {

struct Mapping {
  std::uintptr_t begin = 0, end = 0;
  ino_t inode = 0;
  int port = 0;
};

/// A line of /proc/self/maps, when it is that of a port without a name.
std::optional<Mapping> orphan(const std::string& line) {
  static constexpr std::string_view kPort = "/dev/shm/fastrtps_port", kDeleted = " (deleted)";
  const auto at = line.find(kPort);
  if (at == std::string::npos || !line.ends_with(kDeleted)) return std::nullopt;
  unsigned long begin = 0, end = 0, inode = 0;
  Mapping mapping;
  if (std::sscanf(line.c_str(), "%lx-%lx %*s %*s %*s %lu", &begin, &end, &inode) != 3 ||
      std::sscanf(line.c_str() + at + kPort.size(), "%d", &mapping.port) != 1) {
    return std::nullopt;
  }
  mapping.begin = begin;
  mapping.end = end;
  mapping.inode = inode;
  return mapping;
}

// Through the kernel: Fast DDS may unmap the port at any moment, which then is an error and not a crash.
bool transfer(decltype(&process_vm_readv) call, void* here, std::uintptr_t there, std::size_t size) {
  const iovec local{here, size}, remote{reinterpret_cast<void*>(there), size};
  return call(getpid(), &local, 1, &remote, 1, 0) == static_cast<ssize_t>(size);
}

/// From PortNode of Fast DDS 2.9 (SharedMemGlobal.hpp), 32 bits each.
struct PortState {
  std::uint32_t port, listeners, check_ms, wait_ms, capacity, waiting, flags;
};
constexpr std::uint32_t kOk = 1;  // the first of the flags

/// Where in the mapping the state is; 0 when it isn't laid out so.
std::uintptr_t find_state(const Mapping& mapping) {
  std::vector<char> bytes(mapping.end - mapping.begin);
  if (!transfer(process_vm_readv, bytes.data(), mapping.begin, bytes.size())) return 0;
  if (std::string_view(bytes.data(), bytes.size()).find("port_node_abi5") == std::string_view::npos) return 0;
  PortState state{};
  for (std::size_t at = 0; at + sizeof state <= std::min<std::size_t>(bytes.size(), 4096); at += 4) {
    std::memcpy(&state, bytes.data() + at, sizeof state);
    if (state.port == static_cast<std::uint32_t>(mapping.port) && state.check_ms > 0 &&
        state.wait_ms == state.check_ms / 3 && state.capacity > 0) {
      return mapping.begin + at;
    }
  }
  return 0;
}

bool mark_not_ok(const Mapping& mapping) {
  const std::uintptr_t at = find_state(mapping);
  PortState state{};
  // Read again, so that hardly any time passes in which another could change the flags or unmap the port.
  if (at == 0 || !transfer(process_vm_readv, &state, at, sizeof state)) return false;
  if (state.port != static_cast<std::uint32_t>(mapping.port) || (state.flags & kOk) == 0) return false;
  state.flags &= ~kOk;
  return transfer(process_vm_writev, &state.flags, at + offsetof(PortState, flags), sizeof state.flags);
}

}  // namespace

std::vector<int> OrphanedPorts::mark() {
  std::vector<int> marked;
  std::set<ino_t> seen;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const auto mapping = orphan(line);
    if (!mapping) continue;
    seen.insert(mapping->inode);
    if (seen_.contains(mapping->inode) && mark_not_ok(*mapping)) marked.push_back(mapping->port);
  }
  seen_ = std::move(seen);
  return marked;
}

}  // namespace primo::bus

// Shared memory can be had or not: found out before Fast DDS falls back to something slower without a word.
#pragma once

#include <cstddef>

#include "core/result.h"

namespace primo::bus {

/// Allocates that much in /dev/shm and gives it back. Error: unavailable, with the reason.
Status probe_shared_memory(std::size_t bytes);

/// Whether this process has a Fast DDS segment mapped.
bool shared_memory_mapped();

}  // namespace primo::bus

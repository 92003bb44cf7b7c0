// Shared memory can be had or not: found out before Fast DDS falls back to something slower without a word.
#pragma once

#include <cstddef>
#include <string>

#include "core/result.h"

namespace primo::bus {

/// Allocates that much in /dev/shm and gives it back. Error: unavailable, with the reason.
Status probe_shared_memory(std::size_t bytes);

/// Whether this process has a Fast DDS segment mapped; true where that cannot be told.
bool shared_memory_mapped();

/// A participant number below `count` whose shared-memory ports in this domain have no file yet, or −1 when all have
/// one. Fast DDS gives a restarted process the port of the dead one; whoever then finds the dead port removes and makes
/// it anew, and when that happens while the restarted process has just opened it, that process listens to a deleted
/// file for ever. A port that nobody ever had is nobody's to recover.
int unused_participant_id(int domain, int count);

/// Removes the segments and ports that processes left behind which were killed: those that nobody has locked and, of
/// ports, which others may be writing to, those that nobody has mapped either. Files younger than a second may be about
/// to be locked by a process that starts: where there are any, it looks again after that second. Gives their number.
int remove_dead_shared_memory();

}  // namespace primo::bus

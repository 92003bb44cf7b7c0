// Ports of Fast DDS's shared memory that lost their name while in use, and how they are got rid of (decision 0703).
#pragma once

#include <sys/types.h>

#include <set>
#include <vector>

namespace primo::bus {

/// Fast DDS 2.9 removes the file of a port and makes it anew when it takes the port for dead. Its test for that is not
/// atomic: two processes that test at once can find each other's lock file. Whoever has the old file mapped then
/// listens there, or writes there, for ever, and neither notices. A port that is marked as not ok, however, is closed
/// and opened by its present name by each who uses it. This marks the orphans.
class OrphanedPorts {
 public:
  /// Marks the ports that this process has mapped without a name, if they were so at the last call too. Gives their
  /// numbers. A port whose memory isn't laid out as in Fast DDS 2.9 is left alone.
  std::vector<int> mark();

 private:
  std::set<ino_t> seen_;
};

}  // namespace primo::bus

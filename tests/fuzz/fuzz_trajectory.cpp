// Trajectory files from anywhere: plan_from_json() must answer with a plan or an error, never crash or hang.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "primo/trajectory_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto plan = primo::tool::plan_from_json({data, data + size});
  if (!plan.ok()) {
    if (plan.error().message.empty()) std::abort();
    return 0;
  }
  // What was accepted survives being written and read.
  const std::string text = primo::tool::trajectory_json(*plan).dump();
  const auto again = primo::tool::plan_from_json(text);
  if (!again.ok() || primo::tool::trajectory_json(*again).dump() != text) std::abort();
  return 0;
}

// Scenario files from anywhere: read_scenario_text() must answer with a valid scenario or an error, never crash or
// hang.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "scene/scenario.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto scenario = primo::scene::read_scenario_text({data, data + size}, "fuzz.yaml");
  if (!scenario.ok()) {
    if (scenario.error().message.empty()) std::abort();
    return 0;
  }
  // What was accepted is valid and survives being written and read.
  const auto again = primo::scene::read_scenario_text(primo::config::dump(*scenario), "dump");
  if (!again.ok() || primo::scene::scene_id(*again) != primo::scene::scene_id(*scenario)) std::abort();
  return 0;
}

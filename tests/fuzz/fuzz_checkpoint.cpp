// Checkpoints from anywhere: optimizer_from_text() must answer with an optimizer that works or an error, never crash or
// hang. The bytes are also taken as a bare state, so that what lies behind the checkpoint's digest is reached too.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "optim/checkpoint.h"

namespace {

/// Goes on for a few generations: whatever was accepted stays in the box.
void live(primo::optim::Optimizer& optimizer) {
  for (int generation = 0; generation < 3 && !optimizer.done(); ++generation) {
    for (const auto& candidate : optimizer.ask()) {
      for (const double x : candidate.x) {
        if (!(x >= -2 && x <= 6)) std::abort();
      }
      if (!optimizer.tell(candidate.generation, candidate.index, -candidate.x[0]).ok()) std::abort();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  const primo::optim::Bounds bounds{{-2, -2, -2}, {6, 6, 6}};
  for (const auto& name : primo::optim::optimizer_names()) {
    const primo::optim::OptimizerSettings settings{.name = name, .evaluations = 300};
    const auto read = primo::optim::optimizer_from_text(text, settings, bounds, "sphere");
    if (!read.ok() && read.error().message.empty()) std::abort();
    if (read.ok()) live(**read);

    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) continue;
    primo::optim::State state;
    for (const auto& [key, values] : json.items()) {
      if (!values.is_array() || values.size() > 1000) continue;
      for (const auto& value : values) state[key].push_back(value.is_number() ? value.get<double>() : 0);
    }
    auto optimizer = primo::optim::make_optimizer(settings, bounds).value();
    if (optimizer->restore(state).ok()) live(*optimizer);
  }
  return 0;
}

// What stands in for the folder graph where primo is built without DDS.
#ifndef PRIMO_WITH_DDS
#include "primo/study_graph.h"

namespace primo::tool {
namespace {
Error without_dds() {
  return {Code::unavailable, "this primo was built without DDS; run the study in one process with --local"};
}
}  // namespace

Status check_graph(const std::string&, const study::Study&) { return without_dds(); }
Status run_on_graph(const std::string&, const study::Study&, const std::filesystem::path&) { return without_dds(); }

}  // namespace primo::tool
#endif

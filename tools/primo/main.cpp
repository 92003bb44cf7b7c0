// primo: the command line. Exit codes: 0; 1 the run failed; 64 usage; 69 a needed service is missing; 70 internal; 78
// configuration.
#include <algorithm>
#include <exception>

#include "primo/verbs.h"

namespace primo::tool {

std::vector<AddVerb> verbs() {
  return {
#ifdef PRIMO_WITH_DDS
      add_up,    add_down, add_status,
#endif
      add_study, add_plan, add_judge,  add_rollout, add_scenario, add_rules, add_optimize, add_config,
  };
}

namespace {

bool knows(const CLI::App& app, const std::string& verb) {
  const auto all = app.get_subcommands([](const CLI::App*) { return true; });
  return std::any_of(all.begin(), all.end(), [&](const CLI::App* one) { return one->get_name() == verb; });
}

int run(int argc, char** argv) {
  CLI::App app{"primo optimizes motion primitives until the robot's symbolic rules predict what happens.", "primo"};
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0; 1 the run failed; 64 usage; 69 a needed service is missing; 70 internal; 78 configuration.");
  int exit = 0;
  for (const AddVerb add : verbs()) add(app, exit);
  if (argc > 1 && argv[1][0] != '-' && !knows(app, argv[1])) {
    std::fprintf(stderr, "primo: unknown verb '%s'; primo --help lists them\n", argv[1]);
    return exit_code(Code::usage);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : exit_code(Code::usage);
  }
  return exit;
}

}  // namespace
}  // namespace primo::tool

int main(int argc, char** argv) {
  try {
    return primo::tool::run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "primo: internal error: %s\n", e.what());
    return primo::exit_code(primo::Code::internal);
  }
}

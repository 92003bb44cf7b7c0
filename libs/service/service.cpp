#include "service/service.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <thread>

#include "core/hash.h"

namespace primo::service {
namespace {

/// One line each, with the time first: what supervisors and people grep.
void set_logging_up(const std::string& name, const std::string& level) {
  auto logger = spdlog::stderr_logger_mt(name);
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e %-7l %n: %v");
  logger->set_level(spdlog::level::from_str(level));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

int fail(const std::string& who, const Error& error) {
  std::fprintf(stderr, "%s: %s\n", who.c_str(), error.message.c_str());
  return exit_code(error.code);
}

struct CommandLine {
  std::string config_file;
  std::vector<std::string> settings;
  std::optional<int> domain;
  std::string name, log_level;
  bool check_only = false, print_config = false;
  std::vector<std::string> option_values;
};

/// The exit code when the process is not to go on.
std::optional<int> parse(const Launch& launch, int argc, char** argv, CommandLine& line) {
  CLI::App app("The " + launch.role + " of primo.");
  app.footer("Keys of the configuration file, with their defaults:\n" + launch.description);
  app.add_option("--config", line.config_file, "configuration file (YAML)")->type_name("FILE");
  app.add_option("--set", line.settings, "override a key of the configuration; may be repeated")
      ->type_name("KEY=VALUE");
  app.add_option("--domain", line.domain, "DDS domain, 0 to 232; stronger than PRIMO_DOMAIN")->type_name("N");
  app.add_option("--name", line.name, "name of this process, e.g. " + launch.role + "1")->type_name("NAME");
  app.add_option("--log-level", line.log_level, "debug, info, warn or error")->type_name("LEVEL");
  app.add_flag("--check-config", line.check_only, "check the configuration and exit");
  app.add_flag("--print-config", line.print_config, "print the effective configuration and exit");
  line.option_values.resize(launch.options.size());
  for (std::size_t i = 0; i < launch.options.size(); ++i) {
    const Option& option = launch.options[i];
    app.add_option(option.flag, line.option_values[i], option.help)->type_name(option.value_name);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const bool asked = e.get_exit_code() == 0;  // --help
    app.exit(e);
    return asked ? 0 : exit_code(Code::usage);
  }
  return std::nullopt;
}

/// The parsed file with the command line's overrides.
Result<YAML::Node> configuration(const Launch& launch, const CommandLine& line) {
  YAML::Node node(YAML::NodeType::Map);
  if (!line.config_file.empty()) {
    PRIMO_ASSIGN(const std::string text, read_file(line.config_file));
    PRIMO_ASSIGN(node, config::detail::parse(text, line.config_file));
  }
  std::vector<std::string> assignments = line.settings;
  if (!line.name.empty()) assignments.push_back("service.name=" + line.name);
  if (!line.log_level.empty()) assignments.push_back("service.log_level=" + line.log_level);
  for (std::size_t i = 0; i < line.option_values.size(); ++i) {
    if (!line.option_values[i].empty()) assignments.push_back(launch.options[i].key + "=" + line.option_values[i]);
  }
  return config::override_keys(node, assignments);
}

/// Blocked before any thread starts, so that only the waiting thread of Context gets them.
sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGUSR2);  // ends the waiting thread
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

}  // namespace

struct Context::Impl {
  Impl(Common common_in, std::string name_in, bus::Participant participant_in)
      : common(std::move(common_in)), name(std::move(name_in)), participant(std::move(participant_in)) {}

  void wait_for_signals(const sigset_t& signals);
  void end_signals();

  Common common;
  std::string name;
  bus::Participant participant;
  std::shared_ptr<bus::StatusPublisher> status;
  std::shared_ptr<spdlog::logger> logger;
  std::stop_source stop;
  std::mutex mutex;
  std::condition_variable_any changed;
  std::string waiting_said;
  std::atomic<bool> over{false};
  std::atomic<bool> forgotten{false};
  std::thread signal_thread;
};

void Context::Impl::wait_for_signals(const sigset_t& signals) {
  signal_thread = std::thread([this, signals] {
    int told = 0;
    while (true) {
      int signal = 0;
      if (sigwait(&signals, &signal) != 0) continue;
      if (over) return;
      if (signal == SIGUSR2) continue;
      if (++told > 1) {
        std::fprintf(stderr, "%s: told to stop a second time; ending at once\n", name.c_str());
        _exit(exit_code(Code::failed));
      }
      logger->info("told to stop by {}", signal == SIGTERM ? "SIGTERM" : "SIGINT");
      stop.request_stop();
    }
  });
}

void Context::Impl::end_signals() {
  over = true;
  if (!signal_thread.joinable()) return;
  pthread_kill(signal_thread.native_handle(), SIGUSR2);
  signal_thread.join();
}

Context::Context(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Context::~Context() { impl_->end_signals(); }

bus::Participant& Context::participant() { return impl_->participant; }
bus::StatusPublisher& Context::status() { return *impl_->status; }
Result<std::unique_ptr<bus::StatusWatcher>> Context::make_watcher() {
  return bus::StatusWatcher::create(impl_->participant, std::chrono::milliseconds(impl_->common.lease_ms));
}
spdlog::logger& Context::log() { return *impl_->logger; }
const std::string& Context::name() const { return impl_->name; }
const Common& Context::common() const { return impl_->common; }
bool Context::stopping() const { return impl_->stop.stop_requested(); }
std::stop_token Context::stop_token() const { return impl_->stop.get_token(); }
void Context::stop() { impl_->stop.request_stop(); }
bool Context::forgotten() const { return impl_->forgotten; }

bool Context::wait(std::chrono::milliseconds timeout) {
  std::unique_lock lock(impl_->mutex);
  impl_->changed.wait_for(lock, impl_->stop.get_token(), timeout, [] { return false; });
  return stopping();
}

void Context::waiting_for(const std::string& text) {
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->waiting_said == text) return;
    impl_->waiting_said = text;
  }
  if (!text.empty()) {
    impl_->logger->info("waiting for {}", text);
  } else {
    impl_->logger->info("no longer waiting");
  }
  impl_->status->waiting_for(text);
}

bus::ServerSettings Context::server_settings() const {
  bus::ServerSettings settings;
  settings.credits = static_cast<unsigned>(impl_->common.credits);
  return settings;
}

std::chrono::milliseconds Context::drain_time() const {
  return std::chrono::milliseconds(static_cast<std::int64_t>(impl_->common.drain_seconds * 1000));
}

void Context::started() {
  impl_->logger->info("takes jobs as {} in domain {}", impl_->participant.id(), impl_->participant.domain());
}

void Context::give_up_draining() {
  impl_->logger->error("the job in work didn't end within {} s; ending without it", impl_->common.drain_seconds);
  impl_->logger->flush();
  _exit(exit_code(Code::internal));  // the handler's thread can't be joined
}

namespace {

Result<std::unique_ptr<Context>> make_context(const Launch& launch, const std::string& effective, const Common& common,
                                              const sigset_t& signals) {
  const std::string name = common.name.empty() ? launch.role : common.name;
  PRIMO_ASSIGN(auto participant, bus::Participant::create(common.bus, name));
  auto impl = std::make_unique<Context::Impl>(common, name, std::move(participant));
  impl->logger = spdlog::default_logger();
  bus::StatusSettings status;
  status.role = launch.role;
  status.config_hash = content_id(effective);
  status.version = PRIMO_VERSION;
  status.lease = std::chrono::milliseconds(common.lease_ms);
  status.membership = std::chrono::milliseconds(common.bus.lease_ms);
  status.on_lost = [raw = impl.get()](const std::string& why) {
    if (raw->forgotten.exchange(true)) return;
    raw->logger->error("{}; it ends to be started anew", why);
    raw->stop.request_stop();
  };
  PRIMO_ASSIGN(impl->status, bus::StatusPublisher::create(impl->participant, std::move(status)));
  impl->participant.on_problem([weak = std::weak_ptr(impl->status)](const std::string& problem) {
    if (const auto publisher = weak.lock()) publisher->set_error(problem);
  });
  impl->wait_for_signals(signals);
  return std::make_unique<Context>(std::move(impl));
}

Status guarded(const Launch& launch, Context& context) {
  try {
    return launch.body(context);
  } catch (const std::exception& e) {
    return Error{Code::internal, std::string("unexpected: ") + e.what()};
  }
}

}  // namespace

int launch(const Launch& launch, int argc, char** argv) {
  const std::string who = "primo_" + launch.role;
  CommandLine line;
  if (const auto code = parse(launch, argc, argv, line)) return *code;
  const auto node = configuration(launch, line);
  if (!node.ok()) return fail(who, node.error());
  const auto effective = launch.check(*node, line.config_file.empty() ? "command line" : line.config_file);
  if (!effective.ok()) return fail(who, effective.error());
  Common common = launch.common();
  if (line.domain) common.bus.domain_override = line.domain;
  if (const auto domain = bus::effective_domain(common.bus); !domain.ok()) return fail(who, domain.error());
  if (line.print_config) std::fputs(effective->c_str(), stdout);
  if (line.check_only || line.print_config) return 0;

  set_logging_up(common.name.empty() ? launch.role : common.name, common.log_level);
  const sigset_t signals = block_signals();
  auto context = make_context(launch, *effective, common, signals);
  if (!context.ok()) {
    spdlog::error("{}", context.error().message);
    return exit_code(context.error().code);
  }
  const Status done = guarded(launch, **context);
  (*context)->status().set_state(bus::State::draining);
  if (!done.ok() && !((*context)->stopping() && done.error().code == Code::unavailable)) {
    spdlog::error("{}", done.error().message);
    return exit_code(done.error().code);
  }
  if ((*context)->forgotten()) return exit_code(Code::unavailable);
  spdlog::info("ended");
  return 0;
}

}  // namespace primo::service

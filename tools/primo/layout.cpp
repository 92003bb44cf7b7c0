#include "primo/layout.h"

#include <charconv>
#include <cstdlib>
#include <optional>

#include "core/files.h"

namespace primo::tool {
namespace fs = std::filesystem;
namespace {

std::optional<int> parse_domain(const std::string& text) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || value < 0 || value > 232) return std::nullopt;
  for (const char* c = end; c != text.data() + text.size(); ++c) {
    if (*c != '\n' && *c != ' ') return std::nullopt;
  }
  return value;
}

bool is_root(const fs::path& path) {
  std::error_code ec;
  return fs::exists(path / "compose" / "supervisord.conf", ec);
}

Result<fs::path> find_root(const fs::path& bin) {
  if (const char* root = std::getenv("PRIMO_ROOT")) {
    if (!is_root(root))
      return Error{Code::config, std::string("PRIMO_ROOT is ") + root + ", which holds no compose/supervisord.conf"};
    return fs::absolute(root);
  }
  for (fs::path path = bin; path != path.root_path(); path = path.parent_path()) {
    if (is_root(path)) return path;
  }
  if (is_root(fs::current_path())) return fs::current_path();
  return Error{Code::config, "no folder with compose/supervisord.conf stands above " + bin.string() +
                                 "; set PRIMO_ROOT to primo's checkout"};
}

}  // namespace

Result<Layout> find_layout(const std::string& run, int domain) {
  Layout layout;
  std::error_code ec;
  const fs::path self = fs::read_symlink("/proc/self/exe", ec);
  if (ec) return Error{Code::internal, "/proc/self/exe cannot be read: " + ec.message()};
  layout.bin = self.parent_path();
  PRIMO_ASSIGN(layout.root, find_root(layout.bin));
  const char* services = std::getenv("PRIMO_SERVICES");
  layout.services = services ? fs::absolute(services) : layout.root / "services";
  const char* env_run = std::getenv("PRIMO_RUN");
  layout.run = !run.empty() ? fs::absolute(run) : env_run ? fs::absolute(env_run) : layout.root / ".primo";
  layout.run = layout.run.lexically_normal();
  layout.robot = layout.root / "configs" / "robots" / "schunk_lwa3_sdh2.yaml";
  if (const fs::path file = layout.run / "robot"; fs::exists(file, ec)) {
    PRIMO_ASSIGN(layout.robot, read_file(file));
  }

  if (domain >= 0) {
    layout.domain = domain;
    return layout;
  }
  if (const fs::path file = layout.run / "domain"; fs::exists(file, ec)) {
    PRIMO_ASSIGN(const std::string text, read_file(file));
    const auto known = parse_domain(text);
    if (!known) return Error{Code::config, file.string() + ": is '" + text + "', expected a DDS domain from 0 to 232"};
    layout.domain = *known;
    return layout;
  }
  if (const char* text = std::getenv("PRIMO_DOMAIN")) {
    const auto known = parse_domain(text);
    if (!known)
      return Error{Code::config, std::string("PRIMO_DOMAIN is '") + text + "', expected a whole number from 0 to 232"};
    layout.domain = *known;
  }
  return layout;
}

Status remember_graph(const Layout& layout) {
  std::error_code ec;
  fs::create_directories(layout.run, ec);
  if (ec) return Error{Code::config, layout.run.string() + ": cannot be made: " + ec.message()};
  PRIMO_TRY(write_file(layout.run / "robot", layout.robot.string()));
  return write_file(layout.run / "domain", std::to_string(layout.domain) + "\n");
}

void forget_graph(const Layout& layout) {
  std::error_code ec;
  fs::remove(layout.run / "robot", ec);
  fs::remove(layout.run / "domain", ec);
}

Result<fs::path> move_aside(const fs::path& path) {
  std::error_code ec;
  if (!fs::exists(path, ec)) return path;
  for (int i = 1; i < 100000; ++i) {
    const fs::path aside = path.string() + "." + std::to_string(i);
    if (fs::exists(aside, ec)) continue;
    fs::rename(path, aside, ec);
    if (ec) return Error{Code::config, path.string() + ": cannot be moved to " + aside.string() + ": " + ec.message()};
    return aside;
  }
  return Error{Code::config, path.string() + ": 100000 older folders stand beside it; remove some"};
}

}  // namespace primo::tool

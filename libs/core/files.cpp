#include "core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace primo {

Result<std::string> read_file(const std::filesystem::path& path) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec))
    return Error{Code::config, path.string() + ": is a directory, expected a file"};
  std::ifstream in(path, std::ios::binary);
  if (!in) return Error{Code::config, path.string() + ": cannot be read: " + std::strerror(errno)};
  std::ostringstream text;
  text << in.rdbuf();
  return std::move(text).str();
}

Status write_file(const std::filesystem::path& path, std::string_view content) {
  const auto failed = [&](const std::string& what) {
    return Error{Code::failed, path.string() + ": " + what + ": " + std::strerror(errno)};
  };
  const std::string temporary = path.string() + ".tmp." + std::to_string(::getpid());
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return failed("cannot be written");
  const auto abandon = [&](const std::string& what) {
    auto error = failed(what);
    ::close(fd);
    ::unlink(temporary.c_str());
    return error;
  };
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t n = ::write(fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return abandon("write failed");
    done += static_cast<std::size_t>(n);
  }
  if (::fsync(fd) != 0) return abandon("fsync failed");
  if (::close(fd) != 0) {
    auto error = failed("close failed");
    ::unlink(temporary.c_str());
    return error;
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    auto error = failed("cannot be replaced");
    ::unlink(temporary.c_str());
    return error;
  }
  return success();
}

}  // namespace primo

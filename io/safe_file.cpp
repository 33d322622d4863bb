// SPDX-License-Identifier: Apache-2.0
#include "io/safe_file.hpp"

#include "core/error.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

/// Closes a descriptor that is only read.
struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

}  // namespace

SafeFile::SafeFile(const std::string& path) : path_(path) {
  const std::string stem = path + ".tmp" + std::to_string(::getpid()) + '-';
  for (int k = 0; file_ < 0; ++k) {
    temporary_ = stem + std::to_string(k);
    file_ = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_APPEND | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) fail("write");
  }
}

SafeFile::~SafeFile() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(temporary_.c_str());
}

void SafeFile::fail(const char* action) const {
  const std::string reason = std::strerror(errno);
  throw Error(concat("cannot ", action, ' ', path_, ": ", reason), ErrorKind::kResources);
}

void SafeFile::write(const void* data, size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::write(file_, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("write");
    at += n;
    bytes -= size_t(n);
  }
}

void SafeFile::commit() {
  if (::fsync(file_) != 0) fail("write");
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("write");
  const int file = std::exchange(file_, -1);
  if (::close(file) != 0) fail("write");

  // the new name is safe once the folder is; some file systems cannot sync folders
  const fs::path folder = fs::path(path_).parent_path();
  const Descriptor d{::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY)};
  if (d.value >= 0 && ::fsync(d.value) != 0 && errno != EINVAL && errno != EROFS) fail("write");
}

void write_file(const std::string& path, std::string_view content) {
  SafeFile file(path);
  file.write(content);
  file.commit();
}

std::string read_file(const std::string& path, int64_t max_bytes) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  ELASTOGEN_CHECK_ASSET(file.value >= 0, path, ": ", std::strerror(errno));
  struct stat status = {};
  ELASTOGEN_CHECK_ASSET(::fstat(file.value, &status) == 0, path, ": ", std::strerror(errno));
  ELASTOGEN_CHECK_ASSET(!S_ISDIR(status.st_mode), path, ": is a folder, not a file");
  ELASTOGEN_CHECK_ASSET(S_ISREG(status.st_mode), path, ": is not a regular file");
  ELASTOGEN_CHECK_ASSET(status.st_size <= max_bytes, path, ": has ", int64_t(status.st_size),
                        " bytes, at most ", max_bytes, " are read");

  std::string content(size_t(status.st_size), '\0');
  size_t done = 0;
  while (done < content.size()) {
    const ssize_t n = ::read(file.value, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    ELASTOGEN_CHECK_ASSET(n >= 0, path, ": ", std::strerror(errno));
    if (n == 0) break;  // it became shorter meanwhile
    done += size_t(n);
  }
  content.resize(done);
  return content;
}

std::string resolve_beside(const std::string& path, const std::string& name) {
  std::string turned = name;
  std::replace(turned.begin(), turned.end(), '\\', '/');
  if (turned.empty() || turned.find('\0') != turned.npos || turned.find(':') != turned.npos ||
      fs::path(turned).is_absolute())
    return "";

  std::error_code error;
  const fs::path parent = fs::path(path).parent_path();
  const fs::path folder = fs::canonical(parent.empty() ? "." : parent, error);
  if (error) return "";
  const fs::path file = fs::canonical(folder / turned, error);
  if (error || !fs::is_regular_file(file, error)) return "";
  const auto [in_folder, rest] =
      std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return in_folder == folder.end() ? file.string() : "";
}

}  // namespace elastogen

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

/// Closes a file descriptor that was opened for reading.
struct Descriptor {
  int value;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// Calls action(name) with temporary names until one is free.
/// @return the name, or "" with errno set.
template <class Action>
std::string first_free_name(const std::string& path, const Action& action) {
  for (int k = 0;; ++k) {
    std::string name = path + ".tmp" + std::to_string(::getpid()) + '-' + std::to_string(k);
    if (action(name.c_str())) return name;
    if (errno != EEXIST) return "";
  }
}

}  // namespace

SafeFile::SafeFile(const std::string& path) : path_(path) {
  // commit() would replace a device or pipe that has the name
  std::error_code error;
  const fs::file_status there = fs::status(path, error);
  if (fs::exists(there) && !fs::is_regular_file(there) && !fs::is_directory(there))
    throw Error(concat("cannot write ", path, ": it is a device or pipe, no file"),
                ErrorKind::kResources);
  // the system frees a file without a name when the process ends, however it ends
  file_ = ::open(folder_of(path).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (file_ >= 0) {
    temporary_ = "/proc/self/fd/" + std::to_string(file_);
    return;
  }
  if (errno != EOPNOTSUPP && errno != EISDIR) fail("write");
  named_ = true;
  temporary_ = first_free_name(path, [this](const char* name) {
    file_ = ::open(name, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
    return file_ >= 0;
  });
  if (file_ < 0) fail("write");
}

SafeFile::~SafeFile() {
  if (file_ < 0) return;
  ::close(file_);
  if (named_) ::unlink(temporary_.c_str());
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
  if (!named_) {
    const std::string name = first_free_name(path_, [this](const char* free) {
      return ::linkat(AT_FDCWD, temporary_.c_str(), AT_FDCWD, free, AT_SYMLINK_FOLLOW) == 0;
    });
    if (name.empty()) fail("write");
    temporary_ = name;
    named_ = true;
  }
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("write");
  const int file = std::exchange(file_, -1);
  if (::close(file) != 0) fail("write");

  // sync the folder to make the new name durable; some file systems cannot sync folders
  const Descriptor d{::open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY)};
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
    if (n == 0) break;  // it became shorter since it was opened
    done += size_t(n);
  }
  content.resize(done);
  return content;
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return ending;
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

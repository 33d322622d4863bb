// SPDX-License-Identifier: Apache-2.0
// Shared by the harnesses: a property that does not hold ends the process; and a folder for readers
// that need a path.

#pragma once

#include "core/error.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace elastogen::fuzz {

/// Ends the process with the sentence unless the property holds.
inline void require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "property: %.*s\n", int(what.size()), what.data());
  std::abort();
}

inline void require_kind(const Error& error, ErrorKind kind) {
  require(error.kind() == kind, concat("an error of the wrong kind: ", error.what()));
}

/// A folder of this process, removed with it.
class Folder {
 public:
  Folder() : path_(concat("/dev/shm/elastogen-fuzz-", ::getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const { return path_ + '/' + name; }

 private:
  std::string path_;
};

inline std::string path_of(const std::string& name) {
  static const Folder folder;
  return folder.path(name);
}

/// Writes a file into the folder; returns its path.
inline std::string file(const std::string& name, std::string_view bytes) {
  const std::string path = path_of(name);
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  return path;
}

}  // namespace elastogen::fuzz

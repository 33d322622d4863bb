// SPDX-License-Identifier: Apache-2.0
// Files for the tests of io: a folder that vanishes, and the folder of real assets.

#pragma once

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>

namespace elastogen::test {

/// An empty folder of this test, removed with its content.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "elastogen_io_XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make " + name);
    path_ = name;
  }
  ~TempFolder() { std::filesystem::remove_all(path_); }

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, std::string_view content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path(name);
  }

 private:
  std::filesystem::path path_;
};

/// The folder of real assets with a slash behind it, or "" (said aloud) where there is none.
inline std::string assets_folder() {
  const char* folder = std::getenv("ELASTOGEN_ASSETS");
  if (!folder) std::cout << "ELASTOGEN_ASSETS is not set: the real assets are left out\n";
  return folder ? std::string(folder) + '/' : "";
}

/// Runs the call and returns the message of the Error it must throw, after checking its kind.
inline std::string error_of(const std::function<void()>& call, ErrorKind kind = ErrorKind::kAsset) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

/// The text says so.
inline void expect_says(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << '"' << text << "\" lacks \"" << part << '"';
}

}  // namespace elastogen::test

// SPDX-License-Identifier: Apache-2.0
// Other programs that a benchmark runs, and the folder in which it meets them.

#pragma once

#include <string>
#include <vector>

namespace elastogen::bench {

/// Runs a program, found in PATH, with the words as its arguments and waits for it. What it prints
/// goes to standard error.
/// @return its exit code, 128 plus the signal that ended it, or 127 where it cannot be started.
int run_program(const std::string& program, const std::vector<std::string>& words);

/// A folder with a name of its own below the one for temporary files; it goes with everything in
/// it.
class TemporaryFolder {
 public:
  /// @throws Error (resources) where none can be made.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace elastogen::bench

// SPDX-License-Identifier: Apache-2.0
// Other programs that a benchmark runs, and the folder for the files exchanged with them.

#pragma once

#include <string>
#include <vector>

namespace elastogen::bench {

/// Runs a program, found in PATH, with the words as its arguments, and waits for it. Its output
/// goes to standard error.
/// @return its exit code, 128 plus the signal that ended it, or 127 if it cannot be started.
int run_program(const std::string& program, const std::vector<std::string>& words);

/// A folder with a unique name below the one for temporary files; it is removed with everything in
/// it.
class TemporaryFolder {
 public:
  /// @throws Error (resources) if none can be made.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace elastogen::bench

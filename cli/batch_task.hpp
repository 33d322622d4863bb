// SPDX-License-Identifier: Apache-2.0
// `animate --batch`: many scene files in one process.

#pragma once

#include <string>
#include <vector>

namespace elastogen {

struct BatchTask {
  std::vector<std::string> files;  ///< scene files
  std::vector<std::string> words;  ///< typed words without the program, --batch and --jobs
  int jobs = 0;                    ///< scenes at a time; 0: 8 on a card, else one a core
  bool quiet = false;              ///< errors and warnings only
};

/// The words of a command line without the program's name, --batch and its files, and --jobs.
std::vector<std::string> words_without_batch(int argc, const char* const* argv,
                                             const std::vector<std::string>& files);

}  // namespace elastogen

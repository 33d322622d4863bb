// SPDX-License-Identifier: Apache-2.0
#include "cli/batch_task.hpp"

namespace elastogen {

std::vector<std::string> words_without_batch(int argc, const char* const* argv,
                                             const std::vector<std::string>& files) {
  std::vector<std::string> words;
  size_t file = 0;
  bool at_files = false;  // the next file of the list belongs to --batch
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (at_files && file < files.size() && word == files[file]) {
      ++file;
      continue;
    }
    const bool joined = word.starts_with("--batch=");
    at_files = joined || word == "--batch";
    if (joined) ++file;
    if (word == "--jobs") ++k;
    if (!at_files && word != "--jobs" && !word.starts_with("--jobs=")) words.push_back(word);
  }
  return words;
}

}  // namespace elastogen

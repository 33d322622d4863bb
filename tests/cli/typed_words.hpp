// SPDX-License-Identifier: Apache-2.0
// Command lines as a user types them.

#pragma once

#include "cli/options.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen::test {

inline CommandLine parsed_words(std::vector<std::string> words) {
  words.insert(words.begin(), "elastogen");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  return parse_command_line(int(argv.size()), argv.data());
}

/// The options of animate.
inline AnimateOptions animate_options(std::vector<std::string> words) {
  words.insert(words.begin(), "animate");
  const CommandLine line = parsed_words(words);
  EXPECT_TRUE(line.animate);
  return line.animate.value_or(AnimateOptions{});
}

/// Why animate refuses these words.
inline std::string refusal(std::vector<std::string> words) {
  words.insert(words.begin(), "animate");
  return error_of([&] { parsed_words(words); }, ErrorKind::kUsage);
}

/// The options of simulate.
inline AnimateOptions simulate_options(std::vector<std::string> words) {
  words.insert(words.begin(), "simulate");
  return parsed_words(words).animate.value();
}

}  // namespace elastogen::test

// SPDX-License-Identifier: Apache-2.0
// Runs the program elastogen-reader: starts it, gives it at most one file, collects its bytes.

#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace elastogen {

inline constexpr int64_t kReaderMemory = int64_t{1}
                                         << 30;  ///< address space of the process [bytes]
inline constexpr int kReaderSeconds = 10;        ///< CPU time, and wall time

struct ChildOptions {
  std::string program;              ///< the reader; empty: find_reader()
  double seconds = kReaderSeconds;  ///< wall time after which the process is killed
  int64_t max_bytes = 1 << 28;      ///< of the answer
};

/// The program elastogen-reader: beside the running program, else what the environment variable
/// ELASTOGEN_READER names, else where it was installed.
/// @throws Error (asset) if it is at none of these places, saying so.
std::string find_reader();

/// The bytes that the reader writes when it is started with two words.
/// @param input  a descriptor for its standard input; below 0: none.
/// @throws Error (asset): its limits, its crash, a failing exit code.
std::string answer_of_reader(const std::array<std::string, 2>& words, int input,
                             const ChildOptions& options);

}  // namespace elastogen

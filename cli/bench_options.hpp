// SPDX-License-Identifier: Apache-2.0
// The options of `elastogen bench`.

#pragma once

#include "bench/bench.hpp"

#include <string>

namespace CLI {
class App;
}

namespace elastogen {

/// The task of `elastogen bench`.
struct BenchVerb {
  bench::BenchTask task;
  std::string json;  ///< file, empty for none
  int threads = 0;   ///< 0: all
  std::string command;
};

/// Options of `bench` while they are parsed.
class BenchOptions {
 public:
  void add(CLI::App& app, const std::string& command);
  bool parsed() const;
  /// @throws Error (usage) on unknown names and numbers out of range.
  BenchVerb take() const;

 private:
  void add_axes(CLI::App& verb);
  void add_baseline(CLI::App& verb);

  BenchVerb verb_;
  std::string device_ = "auto";
  std::vector<std::string> solvers_ = {"quasi", "newton", "paper"};
  const CLI::App* app_ = nullptr;
};

}  // namespace elastogen

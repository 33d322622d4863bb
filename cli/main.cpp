// SPDX-License-Identifier: Apache-2.0
// Calls the verb; turns errors and reports into exit codes.

#include "cli/exit_code.hpp"
#include "cli/verbs.hpp"

#include <cstdio>

namespace {

int run(int argc, char** argv) {
  using namespace elastogen;
  const CommandLine line = parse_command_line(argc, argv);
  if (line.animate) return animate(*line.animate);
  if (line.batch) return animate_batch(*line.batch);
  if (line.demo) return demo(*line.demo);
  if (line.voxelize) return voxelize(*line.voxelize);
  if (line.inspect) return inspect(*line.inspect);
  if (line.doctor) return doctor(*line.doctor);
  if (line.study) return study(*line.study);
  if (line.bench) return bench_verb(*line.bench);
  if (line.train) return train(*line.train);
  if (line.materials) return materials(*line.materials);
  return line.code;
}

}  // namespace

int main(int argc, char** argv) {
  return elastogen::exit_code_of(
      [&] { return run(argc, argv); },
      [](const char* text) { std::fprintf(stderr, "elastogen: %s\n", text); });
}

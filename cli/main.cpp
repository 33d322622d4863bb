// SPDX-License-Identifier: Apache-2.0
// Calls the verb; turns errors and reports into exit codes.

#include "cli/exit_code.hpp"
#include "cli/verbs.hpp"

#include <cstdio>
#include <exception>
#include <new>

int main(int argc, char** argv) {
  using namespace elastogen;
  try {
    const CommandLine line = parse_command_line(argc, argv);
    if (line.animate) return animate(*line.animate);
    if (line.demo) return demo(*line.demo);
    if (line.voxelize) return voxelize(*line.voxelize);
    if (line.inspect) return inspect(*line.inspect);
    if (line.doctor) return doctor(*line.doctor);
    if (line.study) return study(*line.study);
    if (line.bench) return bench_verb(*line.bench);
    if (line.train) return train(*line.train);
    if (line.materials) return materials(*line.materials);
    return line.code;
  } catch (const Error& error) {
    std::fprintf(stderr, "elastogen: %s\n", error.what());
    return exit_code(error.kind());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "elastogen: out of memory; a coarser grid (--voxels) needs less\n");
    return kExitResources;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "elastogen: %s\n", error.what());
    return kExitResources;
  }
}

// SPDX-License-Identifier: Apache-2.0
// The exit codes of the command (docs/user_guide.md, exit codes). Only cli/ exits.

#pragma once

#include "core/error.hpp"

#include <exception>
#include <new>

namespace elastogen {

enum ExitCode : int {
  kExitDone = 0,           ///< every step converged; warnings are possible
  kExitUsage = 2,          ///< an option, a selection, a unit, contradictory pins
  kExitAsset = 3,          ///< a file that cannot be used, nothing to simulate
  kExitDraft = 4,          ///< a step missed its tolerance or time error, a voxel is inverted, ...
  kExitDiverged = 5,       ///< a step had to be refused; the frames before it were written
  kExitResources = 6,      ///< memory, a budget or a disk is exhausted
  kExitDevice = 7,         ///< --device cuda without a device that can be used
  kExitInterrupted = 130,  ///< SIGINT; the results so far were written
  kExitTerminated = 143,   ///< SIGTERM; the results so far were written
};

/// The code of an exception.
inline ExitCode exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kUsage:
      return kExitUsage;
    case ErrorKind::kAsset:
      return kExitAsset;
    case ErrorKind::kDiverged:
      return kExitDiverged;
    case ErrorKind::kResources:
      return kExitResources;
    case ErrorKind::kDevice:
      return kExitDevice;
  }
  return kExitUsage;
}

/// The code that action() returns, or that of its exception, whose text goes to say(text).
template <class Action, class Say>
int exit_code_of(const Action& action, const Say& say) {
  try {
    return action();
  } catch (const Error& error) {
    say(error.what());
    return exit_code(error.kind());
  } catch (const std::bad_alloc&) {
    say("out of memory; a coarser grid (--voxels) needs less");
    return kExitResources;
  } catch (const std::exception& error) {
    say(error.what());
    return kExitResources;
  }
}

}  // namespace elastogen

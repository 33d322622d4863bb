// SPDX-License-Identifier: Apache-2.0
// Limits that the reader process sets on itself before it reads a file.

#pragma once

namespace elastogen {

/// Limits memory (kReaderMemory), CPU time (kReaderSeconds), open files and core dumps. Files
/// cannot be written, privileges cannot be gained. In all threads, system calls that a reader does
/// not need fail with EPERM: network, processes, removing and renaming, opening for writing. The
/// process ends with its parent.
/// @throws Error (resources) if a limit cannot be set; nothing may be read without all of them.
void limit_process();

}  // namespace elastogen

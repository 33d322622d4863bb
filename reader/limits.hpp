// SPDX-License-Identifier: Apache-2.0
// What the reader process takes from itself before it looks at a file.

#pragma once

namespace elastogen {

/// Limits of memory (kReaderMemory), CPU time (kReaderSeconds), open files and core dumps; no byte
/// into a file; no new privileges; system calls that a reader has no use for fail with EPERM:
/// network, processes, removing and renaming, opening for writing; in all threads. The process
/// ends with its parent.
/// @throws Error (resources) if one of them cannot be set: nothing is read without them.
void limit_process();

}  // namespace elastogen

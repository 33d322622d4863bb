// SPDX-License-Identifier: Apache-2.0
// Version and commit of the build.

#pragma once

#include <string>

namespace elastogen {

std::string version_text();  ///< "elastogen 0.1.0 (commit)"
std::string build_commit();  ///< short hash, "unknown" outside a checkout

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "scene/version.hpp"

namespace elastogen {

std::string build_commit() {
  return ELASTOGEN_COMMIT;
}

std::string version_text() {
  return "elastogen " ELASTOGEN_VERSION " (" ELASTOGEN_COMMIT ")";
}

}  // namespace elastogen

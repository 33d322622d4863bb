// SPDX-License-Identifier: Apache-2.0
// Which derivative of a force Newton's method uses.

#pragma once

#include <cstdint>

namespace elastogen {

/// The derivative as it is, or its positive semi-definite part, element by element.
enum class TangentKind : uint8_t { kTrue, kProjected };

}  // namespace elastogen

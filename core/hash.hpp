// SPDX-License-Identifier: Apache-2.0
// SHA-256 (FIPS 180-4), which names and seals weight files.

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace elastogen {

using Sha256 = std::array<uint8_t, 32>;

/// Digest of bytes.
Sha256 sha256(std::string_view bytes);

/// Its 64 hexadecimal digits, lower case.
std::string hex(const Sha256& digest);

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// Decompression of LZF (M. Lehmann, liblzf), which compressed PCD files use.

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace elastogen {

/// The `size` bytes that were packed; no value if the packed bytes do not give exactly as many.
/// Memory is allocated only if they could give that many (at most 88 times their number).
std::optional<std::string> lzf_unpacked(std::string_view packed, size_t size);

}  // namespace elastogen

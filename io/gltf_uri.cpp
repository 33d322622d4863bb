// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/gltf_source.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

namespace elastogen {

namespace {

/// Value of a base64 digit, -1 for any other character.
int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

Bytes decode_base64(std::string_view text, const std::string& place) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  Bytes bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    ELASTOGEN_CHECK_ASSET(digit >= 0, place, ": the data URI is not valid base64");
    group = group << 6 | uint32_t(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(uint8_t(group >> bits));
  }
  return bytes;
}

/// Replaces %20 and the like by their bytes.
std::string percent_decoded(std::string_view text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size() &&
                        std::isxdigit(uint8_t(text[i + 1])) && std::isxdigit(uint8_t(text[i + 2]));
    if (!escape) {
      result += text[i];
      continue;
    }
    result += char(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
    i += 2;
  }
  return result;
}

/// Whether the URI has a scheme: "http:", "file:", "C:" and any other.
bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  return colon != std::string_view::npos && uri.find('/') > colon;
}

}  // namespace

bool is_data_uri(const std::string& uri) {
  return uri.starts_with("data:");
}

std::string resolve_gltf_uri(const std::string& asset_path, const std::string& uri,
                             const std::string& what) {
  const std::string name = percent_decoded(uri), place = asset_path + ": " + what;
  const bool relative = !has_scheme(uri) && !name.starts_with('/') && !name.starts_with('\\');
  ELASTOGEN_CHECK_ASSET(relative, place, ": the URI must be a path beneath the asset's folder");
  const std::filesystem::path parts(name);
  const bool up = std::any_of(parts.begin(), parts.end(), [](const auto& p) { return p == ".."; });
  ELASTOGEN_CHECK_ASSET(!up, place, ": the URI leaves the asset's folder (\"..\")");
  return resolve_beside(asset_path, name);
}

Bytes read_gltf_uri(const std::string& asset_path, const std::string& uri,
                    const std::string& what) {
  const std::string place = asset_path + ": " + what;
  if (is_data_uri(uri)) {
    const size_t comma = uri.find(',');
    const bool base64 = comma != std::string::npos && uri.substr(0, comma).ends_with(";base64");
    ELASTOGEN_CHECK_ASSET(base64, place, ": only base64 data URIs are read");
    return decode_base64(std::string_view(uri).substr(comma + 1), place);
  }
  const std::string path = resolve_gltf_uri(asset_path, uri, what);
  ELASTOGEN_CHECK_ASSET(!path.empty(), place, ": the file \"", uri,
                        "\" is missing beneath the asset's folder");
  const std::string text = read_file(path);
  return Bytes(text.begin(), text.end());
}

}  // namespace elastogen

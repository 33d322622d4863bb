// SPDX-License-Identifier: Apache-2.0
// Bounded unpacking of a gzip stream (RFC 1952).

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct z_stream_s;

namespace elastogen {

/// Unpacks piece by piece, only as far as asked for.
class GzipReader {
 public:
  /// @param path  for messages; it and the bytes must outlive this.
  GzipReader(std::string_view bytes, const std::string& path);
  ~GzipReader();
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;

  /// The next bytes, fewer only at the end of the stream.
  /// @throws Error (asset) if the stream is damaged (its checksum included) or cut off.
  std::string next(int64_t bytes);

 private:
  int64_t unpack(char* out, int64_t bytes);

  std::unique_ptr<z_stream_s> stream_;
  std::string_view rest_;
  const std::string& path_;
  bool ended_ = false;
};

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "io/gzip_reader.hpp"

#include "core/error.hpp"

#include <zlib.h>

#include <algorithm>

namespace elastogen {
namespace {

constexpr int64_t kMostBytes = 1 << 30;  ///< at a time: zlib counts in 32 bits

}  // namespace

GzipReader::GzipReader(std::string_view bytes, const std::string& path)
    : stream_(std::make_unique<z_stream>()), rest_(bytes), path_(path) {
  constexpr int kGzip = 16;  // added to the size of the window
  ELASTOGEN_CHECK_ASSET(inflateInit2(stream_.get(), kGzip + MAX_WBITS) == Z_OK, path,
                        ": cannot be unpacked");
}

GzipReader::~GzipReader() {
  inflateEnd(stream_.get());
}

std::string GzipReader::next(int64_t bytes) {
  std::string out(size_t(bytes), '\0');
  int64_t done = 0;
  while (done < bytes && !ended_) done += unpack(out.data() + done, bytes - done);
  out.resize(size_t(done));
  return out;
}

int64_t GzipReader::unpack(char* out, int64_t bytes) {
  if (stream_->avail_in == 0) {
    const size_t n = std::min(rest_.size(), size_t(kMostBytes));
    stream_->next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
    stream_->avail_in = uInt(n);
    rest_.remove_prefix(n);
  }
  const uInt capacity = uInt(std::min(bytes, kMostBytes));
  stream_->next_out = reinterpret_cast<Bytef*>(out);
  stream_->avail_out = capacity;
  const int result = inflate(stream_.get(), Z_NO_FLUSH);
  ELASTOGEN_CHECK_ASSET(result == Z_OK || result == Z_STREAM_END, path_,
                        ": its gzip stream is damaged or cut off");
  ended_ = result == Z_STREAM_END;
  return capacity - stream_->avail_out;
}

}  // namespace elastogen

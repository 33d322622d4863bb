// SPDX-License-Identifier: Apache-2.0
#include "io/decode_image.hpp"

#include "core/error.hpp"
#include "io/flat_stream.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace elastogen {
namespace {

/// A file in memory, open for the reader.
class MemoryFile {
 public:
  explicit MemoryFile(const Bytes& bytes) : file_(::memfd_create("image", MFD_CLOEXEC)) {
    bool done = file_ >= 0;
    for (size_t at = 0; done && at < bytes.size();) {
      const ssize_t n = ::write(file_, bytes.data() + at, bytes.size() - at);
      if (n < 0 && errno == EINTR) continue;
      done = n > 0;
      at += done ? size_t(n) : 0;
    }
    done = done && ::lseek(file_, 0, SEEK_SET) == 0;
    if (done) return;
    const int error = errno;
    if (file_ >= 0) ::close(file_);
    throw Error(concat("no memory for an image: ", std::strerror(error)), ErrorKind::kAsset);
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return file_; }

 private:
  int file_ = -1;
};

}  // namespace

std::string encode_image(const Image& image) {
  StreamWriter stream;
  stream.value(uint8_t(0));
  stream.value(image.width);
  stream.value(image.height);
  stream.array(image.rgba);
  return stream.take();
}

Image decode_image_stream(std::string_view bytes) {
  StreamReader stream(bytes);
  begin_answer(stream);
  Image image;
  stream.value(image.width);
  stream.value(image.height);
  stream.array(image.rgba);
  const bool fits = image.width > 0 && image.height > 0 && image.width <= kMaxImageEdge &&
                    image.height <= kMaxImageEdge && stream.left() == 0 &&
                    image.rgba.size() == 4 * size_t(image.width) * size_t(image.height);
  ELASTOGEN_CHECK_ASSET(fits, "its answer is no image");
  return image;
}

Image decode_image(const Bytes& bytes, int max_edge, const ChildOptions& options) {
  ELASTOGEN_CHECK(max_edge > 0, "the longest edge of an image must be positive, got ", max_edge);
  const MemoryFile file(bytes);
  return decode_image_stream(answer_of_reader({std::string(kImageWord), std::to_string(max_edge)},
                                              file.descriptor(), options));
}

}  // namespace elastogen

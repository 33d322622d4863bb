// SPDX-License-Identifier: Apache-2.0
#include "io/frame_store.hpp"

#include "core/error.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

namespace elastogen {

namespace {

[[noreturn]] void fail(const std::string& path, const char* action) {
  throw Error(concat(path, ": ", action, " failed: ", std::strerror(errno)), ErrorKind::kResources);
}

}  // namespace

FrameStore::FrameStore(const std::string& beside, int64_t columns)
    : file_(beside), path_(beside), columns_(columns) {}

void FrameStore::append(In<double> values) {
  ELASTOGEN_CHECK(values.size() == columns_, "a frame must have ", columns_, " values, got ",
                  values);
  const std::vector<float> row(values.data, values.data + values.size());
  const auto bytes = int64_t(row.size() * sizeof(float)), start = frames_ * bytes;
  for (int64_t done = 0; done < bytes;) {
    const char* from = reinterpret_cast<const char*>(row.data()) + done;
    const ssize_t written = ::pwrite(file_.descriptor(), from, size_t(bytes - done), start + done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(path_, "writing a frame");
    done += written;
  }
  ++frames_;
}

void FrameStore::read(int64_t frame, int64_t first, int64_t count, float* values) const {
  const int64_t bytes = count * int64_t(sizeof(float));
  const int64_t start = (frame * columns_ + first) * int64_t(sizeof(float));
  for (int64_t done = 0; done < bytes;) {
    char* to = reinterpret_cast<char*>(values) + done;
    const ssize_t got = ::pread(file_.descriptor(), to, size_t(bytes - done), start + done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(path_, "reading a frame");
    done += got;
  }
}

}  // namespace elastogen

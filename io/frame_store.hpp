// SPDX-License-Identifier: Apache-2.0
// Frames of an animation on disk, in single precision, until all of them are known.

#pragma once

#include "core/array.hpp"
#include "io/safe_file.hpp"

#include <string>

namespace elastogen {

/// Rows of a fixed number of floats in an unnamed file; the file vanishes with the object or the
/// process.
/// @throws Error (resources) from the constructor and append, with the path and the reason.
class FrameStore {
 public:
  /// @param beside  path of the output, in whose folder the file lives.
  FrameStore(const std::string& beside, int64_t columns);
  FrameStore(const FrameStore&) = delete;
  FrameStore& operator=(const FrameStore&) = delete;

  int64_t frames() const { return frames_; }

  /// Adds the values of a frame, rounded to single precision.
  void append(In<double> values);

  /// Columns first, ..., first + count - 1 of a frame.
  void read(int64_t frame, int64_t first, int64_t count, float* values) const;

 private:
  SafeFile file_;  // never committed
  std::string path_;
  int64_t columns_ = 0, frames_ = 0;
};

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "io/point_cache_writer.hpp"

#include "core/error.hpp"
#include "io/frame_files.hpp"
#include "io/frame_store.hpp"
#include "io/safe_file.hpp"

#include <limits>

namespace elastogen {
namespace {

class PointCacheWriter : public AnimationWriter {
 public:
  PointCacheWriter(const std::string& path, const Asset& asset, const Surface& surface)
      : path_(path),
        order_(file_order(asset, surface)),
        scale_(surface.scale),
        frames_(path, int64_t(3 * order_.rest.size())) {}

  void frame(const AnimationFrame& frame) override {
    check_frame(frame, frames_.frames(), int64_t(order_.vertex.size()), false);
    Array<double> positions(int64_t(order_.rest.size()), 3);
    for (size_t v = 0; v < order_.rest.size(); ++v)
      for (int d = 0; d < 3; ++d)
        positions(int64_t(v), d) =
            order_.rest[v][size_t(d)] + frame.displacement(order_.point[v], d) / scale_;
    frames_.append(positions);
  }

  void finish() override {
    ELASTOGEN_CHECK(frames_.frames() > 0, path_, ": there is no frame to write");
    const auto most = size_t(std::numeric_limits<int32_t>::max());
    if (order_.rest.size() > most)
      throw Error(concat(path_, ": PC2 holds at most ", most, " points"), ErrorKind::kResources);
    std::string header("POINTCACHE2\0", 12);
    append(header, int32_t(1));
    append(header, int32_t(order_.rest.size()));
    append(header, 0.0f);
    append(header, 1.0f);
    append(header, int32_t(frames_.frames()));
    SafeFile file(path_);
    file.write(header);
    std::vector<float> values(3 * order_.rest.size());
    for (int64_t f = 0; f < frames_.frames(); ++f) {
      frames_.read(f, 0, int64_t(values.size()), values.data());
      file.write(values.data(), values.size() * sizeof(float));
    }
    file.commit();
  }

 private:
  std::string path_;
  FileOrder order_;
  double scale_;
  FrameStore frames_;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_point_cache_writer(const std::string& path,
                                                         const Asset& asset,
                                                         const Surface& surface) {
  return std::make_unique<PointCacheWriter>(path, asset, surface);
}

}  // namespace elastogen

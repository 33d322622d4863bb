// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/picture_writer.hpp"

#include "cli/png.hpp"
#include "core/error.hpp"
#include "io/frame_files.hpp"
#include "io/frame_store.hpp"

#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kTiles = 12, kColumns = 4;
constexpr int64_t kBatch = 8, kBatchPixels = 1 << 23;  // that are encoded at once
constexpr double kNear = 0.1;  // share of the solid's box, around it, in which points are framed
constexpr int kLeastTexture = 1024;

/// Points of the asset that pictures must show: vertices of triangles, or points near the solid
/// that was made from them, so that a few points far away do not make everything small.
std::vector<int32_t> framed_points(const Setup& setup) {
  const Body& body = setup.body;
  const bool are_vertices = body.is_asset && !setup.particles;
  std::vector<uint8_t> framed(size_t(body.carried.rows()));
  if (are_vertices)
    for (int64_t k = 0; k < body.surface.triangles.size(); ++k)
      framed[size_t(body.surface.triangles.data()[k])] = 1;
  const Box& box = body.surface.box;
  for (int64_t p = 0; p < body.carried.rows() && !are_vertices; ++p) {
    framed[size_t(p)] = 1;
    for (int d = 0; d < 3; ++d)
      framed[size_t(p)] &= body.carried(p, d) >= box.lower[size_t(d)] - kNear * box.extent(d) &&
                           body.carried(p, d) <= box.upper[size_t(d)] + kNear * box.extent(d);
  }
  return filtered(body.carried.rows(), [&](int64_t p) { return framed[size_t(p)] != 0; });
}

std::unique_ptr<Subject> make_subject(const Asset& asset, const Body& body, int max_edge,
                                      std::vector<std::string>& notes) {
  if (asset.splats) return make_splat_subject(*asset.splats, body.surface.scale);
  if (asset.points) return make_point_subject(*asset.points, body.carried);
  return make_mesh_subject(asset, body.surface, max_edge, notes);
}

/// The requested size, else one that suits a tile of a sheet or a single picture.
PictureOptions sized(PictureOptions options, bool numbered) {
  if (options.width == 0) {
    options.width = numbered ? 960 : 320;
    options.height = numbered ? 540 : 320;
  }
  return options;
}

/// Copies a picture into a sheet; a white line separates the tiles.
void place(const Pixels& picture, int left, int top, Pixels& sheet) {
  for (int y = 0; y < picture.height - 1; ++y)
    std::copy_n(picture.rgb.data() + 3 * size_t(y) * size_t(picture.width),
                3 * size_t(picture.width - 1), sheet.row(left, top + y));
}

class PictureWriter : public AnimationWriter {
 public:
  PictureWriter(const std::string& path, const Asset& asset, const Setup& setup, double fps,
                const PictureOptions& options, std::vector<std::string>& notes)
      : path_(path),
        setup_(setup),
        fps_(fps),
        numbered_(!frame_file(path, 0).empty()),
        options_(sized(options, numbered_)),
        subject_(make_subject(asset, setup.body,
                              std::max({kLeastTexture, options_.width, options_.height}), notes)),
        displacements_(path, 3 * setup.body.carried.rows()),
        gradients_(path, 9 * setup.body.carried.rows()) {
    SafeFile probe(numbered_ ? frame_file(path, 0) : path);  // throws now if it cannot be written
  }

  bool needs_gradient() const override { return subject_->needs_gradient(); }

  void frame(const AnimationFrame& frame) override {
    check_frame(frame, displacements_.frames(), setup_.body.carried.rows(), needs_gradient());
    displacements_.append(frame.displacement);
    if (needs_gradient()) gradients_.append(frame.gradient);
  }

  void finish() override {
    ELASTOGEN_CHECK(displacements_.frames() > 0, path_, ": there is no frame to write");
    const std::vector<int32_t> framed = framed_points(setup_);
    const FrameSource source = {
        displacements_.frames(), setup_.body.carried.rows(), fps_,
        [this](int64_t frame, Out<double> x) {
          read(displacements_, frame, x);
          for (int64_t k = 0; k < x.size(); ++k) x.data[k] += setup_.body.carried.data()[k];
        },
        [this](int64_t frame, Out<double> F) { read(gradients_, frame, F); }};
    ScenePicture picture({*subject_, framed, setup_.scene.colliders, setup_.up}, source, options_);
    if (numbered_)
      write_frames(picture);
    else
      write_sheet(picture);
  }

 private:
  static void read(const FrameStore& store, int64_t frame, Out<double> values) {
    std::vector<float> row(size_t(values.size()));
    store.read(frame, 0, values.size(), row.data());
    std::copy(row.begin(), row.end(), values.data);
  }

  void write_frames(ScenePicture& picture) const {
    const int64_t frames = displacements_.frames();
    const int64_t pixels = int64_t(options_.width) * options_.height;
    const int64_t batch = std::clamp<int64_t>(kBatchPixels / pixels, 1, kBatch);
    for (int64_t first = 0; first < frames; first += batch) {
      std::vector<Pixels> drawn;
      for (int64_t f = first; f < std::min(frames, first + batch); ++f)
        drawn.push_back(picture.draw(f));
      std::vector<std::string> packed(drawn.size());
      run_tasks(int64_t(drawn.size()), [&](int64_t k) {
        const Pixels& p = drawn[size_t(k)];
        packed[size_t(k)] = encode_png(p.width, p.height, p.rgb);
      });
      for (size_t k = 0; k < packed.size(); ++k)
        write_file(frame_file(path_, first + int64_t(k)), packed[k]);
    }
  }

  void write_sheet(ScenePicture& picture) const {
    const int64_t frames = displacements_.frames(), tiles = std::min<int64_t>(frames, kTiles);
    const int columns = int(std::min<int64_t>(tiles, kColumns));
    const int rows = int(tiles + columns - 1) / columns;
    Pixels sheet(columns * options_.width, rows * options_.height);
    for (int t = 0; t < int(tiles); ++t) {
      const double share = tiles > 1 ? double(t) / double(tiles - 1) : 0;
      place(picture.draw(std::llround(share * double(frames - 1))), t % columns * options_.width,
            t / columns * options_.height, sheet);
    }
    write_file(path_, encode_png(sheet.width, sheet.height, sheet.rgb));
  }

  std::string path_;
  const Setup& setup_;
  double fps_;
  bool numbered_;
  PictureOptions options_;
  std::unique_ptr<Subject> subject_;
  FrameStore displacements_, gradients_;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_picture_writer(const std::string& path, const Asset& asset,
                                                     const Setup& setup, double fps,
                                                     const PictureOptions& options,
                                                     std::vector<std::string>& notes) {
  return std::make_unique<PictureWriter>(path, asset, setup, fps, options, notes);
}

}  // namespace elastogen

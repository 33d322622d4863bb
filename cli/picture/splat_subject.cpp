// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/subject.hpp"
#include "core/parallel_sort.hpp"
#include "io/byte_reader.hpp"
#include "io/splat_motion.hpp"
#include "io/splat_ply.hpp"

namespace elastogen {
namespace {

constexpr double kBlur = 0.3 * kSamples * kSamples;  // variance of a pixel [samples^2]
constexpr float kFaint = 1.0f / 255;                 // alpha too small to be seen
constexpr float kHidden = 1.0f / 512;                // light from behind too faint to be seen
constexpr float kOpaque = 0.3f;                      // alpha from which on a splat casts a shadow

/// A splat on the canvas: alpha exp(-(a dx^2 + 2 b dx dy + c dy^2) / 2).
struct Spot {
  double x = 0, y = 0;
  float z = 0, a = 0, b = 0, c = 0, alpha = 0;
  int32_t index = 0;
  Light colour = {};  ///< sRGB, as splats are fitted with blended sRGB values
};

class SplatSubject : public Subject {
 public:
  SplatSubject(const SplatCloud& splats, double scale)
      : splats_(splats), motion_(splats), scale_(scale), spots_(splats.position.size()) {}

  bool needs_gradient() const override { return true; }

  void pose(In<double> positions, In<double> gradient) override {
    positions_ = positions;
    motion_.turn(gradient);
  }

  void see(const Camera& camera) override {
    double harmonics[16];
    spherical_harmonics(splats_.degree, scaled(camera.back, -1), harmonics);
    for_each(positions_.rows, [&](int64_t i) { spots_[size_t(i)] = spot(i, camera, harmonics); });
    parallel_sort(spots_.begin(), spots_.end(), [](const Spot& a, const Spot& b) {
      return a.z != b.z ? a.z > b.z : a.index < b.index;
    });
  }

  /// Draws from front to back and stops at opaque samples, so that hidden splats cost nothing.
  void draw(Canvas& canvas) const override {
    std::vector<Light> sum(canvas.light.size(), Light{});
    std::vector<float> through(canvas.light.size(), 1);
    const std::vector<float> behind = canvas.depth;
    for (const Spot& spot : spots_) add(spot, canvas, behind, sum, through);
    for (size_t s = 0; s < sum.size(); ++s) {
      if (through[s] == 1) continue;
      Light& light = canvas.light[s];
      for (size_t c = 0; c < 3; ++c)
        light[c] =
            linear_from_srgb(sum[s][c] + through[s] * srgb_from_linear(std::max(0.0f, light[c])));
    }
  }

  void cast(Canvas& canvas) const override {
    for (const Spot& spot : spots_)
      for_samples(spot, kOpaque, canvas,
                  [&](size_t s, float) { canvas.depth[s] = std::max(canvas.depth[s], spot.z); });
  }

 private:
  /// The projected splat (Zwicker et al. 2001, eq. 31, for an orthographic view).
  Spot spot(int64_t i, const Camera& camera, const double* harmonics) const {
    const double* at = positions_.row(i);
    const Vec3 p = camera.project({at[0], at[1], at[2]});
    const Mat3<double> R = rotation_matrix(motion_.rotation[size_t(i)]);
    double xx = kBlur, xy = 0, yy = kBlur;
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = {R(0, k), R(1, k), R(2, k)};
      const double s = scale_ * camera.scale * double(motion_.scale[size_t(i)][size_t(k)]);
      const double x = s * dot(camera.right, axis), y = -s * dot(camera.up, axis);
      xx += x * x, xy += x * y, yy += y * y;
    }
    const double det = xx * yy - xy * xy;
    Spot spot{p[0], p[1], float(p[2]), float(yy / det), float(-xy / det), float(xx / det)};
    spot.index = int32_t(i);
    spot.alpha = std::min(splats_.opacity[size_t(i)], 0.999f);
    const int count = harmonic_count(splats_.degree);
    const float* coefficient = motion_.harmonics.data() + int64_t(i) * count * 3;
    for (size_t c = 0; c < 3; ++c) {
      double value = 0.5;
      for (int m = 0; m < count; ++m) value += harmonics[m] * coefficient[3 * m + int(c)];
      spot.colour[c] = float(std::clamp(value, 0.0, 1.0));
    }
    return spot;
  }

  /// Calls visit(sample, a dx^2 + 2 b dx dy + c dy^2) where a splat has at least the alpha `least`.
  template <class Visit>
  static void for_samples(const Spot& spot, float least, const Canvas& canvas, const Visit& visit) {
    if (!(spot.alpha > least)) return;
    const double square = 2 * std::log(double(spot.alpha) / least), a = spot.a, b = spot.b,
                 c = spot.c, down = std::sqrt(square * a / (a * c - b * b));
    const SampleRange rows(spot.y - down, spot.y + down, canvas.first, canvas.first + canvas.rows);
    for (int y = rows.begin; y < rows.end; ++y) {
      const double dy = y + 0.5 - spot.y, root = b * b * dy * dy - a * (c * dy * dy - square);
      if (root < 0) continue;
      const double middle = spot.x - b * dy / a, half = std::sqrt(root) / a;
      const SampleRange columns(middle - half, middle + half, 0, canvas.width);
      for (int x = columns.begin; x < columns.end; ++x) {
        const double dx = x + 0.5 - spot.x;
        visit(canvas.sample(x, y), float(a * dx * dx + 2 * b * dx * dy + c * dy * dy));
      }
    }
  }

  static void add(const Spot& spot, Canvas& canvas, const std::vector<float>& behind,
                  std::vector<Light>& sum, std::vector<float>& through) {
    for_samples(spot, kFaint, canvas, [&](size_t s, float square) {
      if (through[s] < kHidden || spot.z <= behind[s]) return;
      const float alpha = spot.alpha * std::exp(-square / 2);
      for (size_t c = 0; c < 3; ++c) sum[s][c] += through[s] * alpha * spot.colour[c];
      through[s] *= 1 - alpha;
    });
  }

  const SplatCloud& splats_;
  SplatMotion motion_;
  double scale_;  ///< metres per file unit
  In<double> positions_ = {};
  std::vector<Spot> spots_;  ///< sorted from front to back
};

}  // namespace

std::unique_ptr<Subject> make_splat_subject(const SplatCloud& splats, double scale) {
  return std::make_unique<SplatSubject>(splats, scale);
}

}  // namespace elastogen

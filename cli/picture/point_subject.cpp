// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/subject.hpp"
#include "io/turned_normal.hpp"
#include "voxelize/point_spacing.hpp"

namespace elastogen {
namespace {

constexpr double kRadius = 0.8;  // of a disc, over the distance to the eighth neighbour
constexpr double kLeast = 0.9;   // least radius of a disc [samples]

class PointSubject : public Subject {
 public:
  PointSubject(const PointCloud& points, const Array<double>& rest) : points_(points) {
    std::vector<Vec3> places(size_t(rest.rows()));
    for (size_t p = 0; p < places.size(); ++p)
      std::copy_n(rest.row(int64_t(p)), 3, places[p].begin());
    radius_ = kRadius * point_spacing(places);
    discs_.resize(places.size());
  }

  bool needs_gradient() const override { return !points_.normal.empty(); }

  void pose(In<double> positions, In<double> gradient) override {
    positions_ = positions;
    gradient_ = gradient;
  }

  void see(const Camera& camera) override {
    reach_ = std::max(kLeast, radius_ * camera.scale);
    scale_ = camera.scale;
    for_each(positions_.rows, [&](int64_t p) {
      const double* x = positions_.row(p);
      discs_[size_t(p)].place = camera.project({x[0], x[1], x[2]});
    });
    double nearest = kNothing, farthest = -kNothing;
    for (const Disc& disc : discs_) {
      nearest = std::max(nearest, disc.place[2]);
      farthest = std::min(farthest, disc.place[2]);
    }
    const double deep = std::max(nearest - farthest, 1e-290);
    for_each(positions_.rows, [&](int64_t p) {
      Disc& disc = discs_[size_t(p)];
      disc.light = colour(p, (disc.place[2] - farthest) / deep);
      const float lit = shade(p, camera);
      for (float& share : disc.light) share *= lit;
    });
  }

  void draw(Canvas& canvas) const override {
    for (const Disc& disc : discs_) draw_disc(disc, canvas);
  }

 private:
  struct Disc {
    Vec3 place;
    Light light;
  };

  /// @param near  0 for the farthest point, 1 for the nearest.
  Light colour(int64_t p, double near) const {
    if (!points_.colour.empty()) {
      const auto& c = points_.colour[size_t(p)];
      return {c[0], c[1], c[2]};
    }
    const auto grey = float(points_.normal.empty() ? 0.12 + 0.43 * near : 0.6);
    return {grey, grey, grey};
  }

  float shade(int64_t p, const Camera& camera) const {
    if (points_.normal.empty()) return 1;
    const auto n = turned_normal(gradient_.row(p), points_.normal[size_t(p)]);
    const Vec3 normal = {n[0], n[1], n[2]};
    Vec3 seen = {dot(camera.right, normal), dot(camera.up, normal), dot(camera.back, normal)};
    const double length = norm(seen);
    if (!(length > 0)) return 1;
    return light_on(scaled(seen, (seen[2] < 0 ? -1 : 1) / length));
  }

  /// Draws a half ball, so that neighbours meet halfway.
  void draw_disc(const Disc& disc, Canvas& canvas) const {
    const Vec3& at = disc.place;
    const SampleRange rows(at[1] - reach_, at[1] + reach_, canvas.first,
                           canvas.first + canvas.rows);
    const SampleRange columns(at[0] - reach_, at[0] + reach_, 0, canvas.width);
    for (int y = rows.begin; y < rows.end; ++y)
      for (int x = columns.begin; x < columns.end; ++x) {
        const double dx = x + 0.5 - at[0], dy = y + 0.5 - at[1];
        const double left = reach_ * reach_ - dx * dx - dy * dy;
        if (left < 0) continue;
        const auto z = float(at[2] + std::sqrt(left) / scale_);
        const size_t sample = canvas.sample(x, y);
        if (z <= canvas.depth[sample]) continue;
        canvas.depth[sample] = z;
        canvas.light[sample] = disc.light;
      }
  }

  const PointCloud& points_;
  double radius_ = 0;             ///< radius of discs [m]
  double reach_ = 0, scale_ = 1;  ///< radius of discs [samples], samples per metre
  In<double> positions_ = {}, gradient_ = {};
  std::vector<Disc> discs_;
};

}  // namespace

std::unique_ptr<Subject> make_point_subject(const PointCloud& points, const Array<double>& rest) {
  return std::make_unique<PointSubject>(points, rest);
}

}  // namespace elastogen

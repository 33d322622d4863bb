// SPDX-License-Identifier: Apache-2.0
#include "network/contact.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <limits>

namespace elastogen {

double contact_layer(const Scene& scene) {
  return scene.grid.h / 4;
}

double slip_range(const Scene& scene) {
  Box box;
  const Array<double>& X = scene.surface.position;
  for (int64_t p = 0; p < X.rows(); ++p) box.add({X(p, 0), X(p, 1), X(p, 2)});
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2), scene.grid.h});
  return 1e-3 * std::sqrt(9.81 * size) * scene.dt;
}

Contact::Contact(const Scene& scene) : scene_(scene) {
  if (!scene.floor) return;
  floor_ = *scene.floor;
  const SurfacePoints& s = scene.surface;
  points_ = s.voxel.rows();
  ELASTOGEN_CHECK(points_ > 0, "a scene with a floor needs surface points");
  ELASTOGEN_CHECK(
      s.weights.rows() == points_ && s.area.rows() == points_ && s.position.rows() == points_,
      "the surface points' arrays differ in length");
  layer_ = contact_layer(scene);
  slip_range_ = slip_range(scene);
  distance_.resize(size_t(points_));
  normal_force_.resize(size_t(points_));
  start_.resize(3 * size_t(points_));
  stiffness_.resize(size_t(points_));
  for (int64_t p = 0; p < points_; ++p) {
    const Material& m = scene.materials[size_t(scene.material(s.voxel(p)))];
    stiffness_[size_t(p)] = s.area(p) * m.young * layer_ * layer_ / scene.grid.h;
  }
  stiff_place_.assign(size_t(scene.grid.node_count()), -1);
}

/// Height of a point at rest above the wall.
double Contact::height(int64_t p) const {
  const Array<double>& X = scene_.surface.position;
  const Vec3& n = floor_.normal;
  return n[0] * X(p, 0) + n[1] * X(p, 1) + n[2] * X(p, 2) - floor_.offset + layer_;
}

void Contact::move_of(int64_t p, const double* u, double result[3]) const {
  const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
  const double* w = scene_.surface.weights.row(p);
  result[0] = result[1] = result[2] = 0;
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) result[i] += w[c] * u[3 * int64_t(corners[c]) + i];
}

double Contact::normal_motion(int64_t p, const double* u) const {
  double d[3];
  move_of(p, u, d);
  return floor_.normal[0] * d[0] + floor_.normal[1] * d[1] + floor_.normal[2] * d[2];
}

void Contact::begin_step(const double* u) {
  for_each(points_, [&](int64_t p) {
    move_of(p, u, start_.data() + 3 * p);
    const double d = height(p) + normal_motion(p, u);
    normal_force_[size_t(p)] =
        d < layer_ ? -stiffness_[size_t(p)] * barrier(d / layer_).first / layer_ : 0;
  });
}

/// Tangential motion of a point since the start of the step; returns its length.
double Contact::slip_of(int64_t p, const double* u, double slip[3]) const {
  move_of(p, u, slip);
  double along = 0;
  for (int i = 0; i < 3; ++i) {
    slip[i] -= start_[size_t(3 * p + i)];
    along += slip[i] * floor_.normal[size_t(i)];
  }
  for (int i = 0; i < 3; ++i) slip[i] -= along * floor_.normal[size_t(i)];
  return std::hypot(slip[0], slip[1], slip[2]);
}

bool Contact::acts(int64_t p) const {
  return distance_[size_t(p)] < layer_ || rubs(p);
}

bool Contact::rubs(int64_t p) const {
  return normal_force_[size_t(p)] > 0 && floor_.friction > 0;
}

/// Energy of one point and its derivative in the point's motion.
double Contact::point_energy(int64_t p, const double* u, double force[3]) const {
  const Curve b = barrier(distance_[size_t(p)] / layer_);
  double energy = stiffness_[size_t(p)] * b.value;
  for (int i = 0; i < 3; ++i)
    force[i] = stiffness_[size_t(p)] * b.first / layer_ * floor_.normal[size_t(i)];
  if (!rubs(p)) return energy;
  double slip[3];
  const SmoothedSlip f = smoothed_slip(slip_of(p, u, slip), slip_range_);
  const double limit = floor_.friction * normal_force_[size_t(p)];
  for (int i = 0; i < 3; ++i) force[i] += limit * f.first_over_y * slip[i];
  return energy + limit * f.value;
}

template <class T>
double Contact::evaluate(const double* u, T* g) {
  for_each(points_, [&](int64_t p) { distance_[size_t(p)] = height(p) + normal_motion(p, u); });
  double energy = 0;
  for (int64_t p = 0; p < points_; ++p) {
    if (distance_[size_t(p)] <= 0) return std::numeric_limits<double>::infinity();
    if (!acts(p)) continue;
    double force[3];
    energy += point_energy(p, u, force);
    if (!g) continue;
    const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
    const double* w = scene_.surface.weights.row(p);
    for (int c = 0; c < 8; ++c) {
      if (scene_.pinned(corners[c])) continue;
      for (int i = 0; i < 3; ++i) g[3 * int64_t(corners[c]) + i] += T(w[c] * force[i]);
    }
  }
  return energy;
}

template double Contact::evaluate(const double*, float*);
template double Contact::evaluate(const double*, double*);

void Contact::linearise(const double* u) {
  for (const int32_t node : stiff_nodes_) stiff_place_[size_t(node)] = -1;
  stiff_nodes_.clear();
  stiff_blocks_.clear();
  active_.clear();
  for_each(points_, [&](int64_t p) { distance_[size_t(p)] = height(p) + normal_motion(p, u); });
  for (int64_t p = 0; p < points_; ++p) {
    if (!acts(p)) continue;
    PointStiffness k{.point = p};
    k.normal =
        stiffness_[size_t(p)] * barrier(distance_[size_t(p)] / layer_).second / (layer_ * layer_);
    if (rubs(p)) {
      const double length = slip_of(p, u, k.direction);
      const SmoothedSlip f = smoothed_slip(length, slip_range_);
      const double limit = floor_.friction * normal_force_[size_t(p)];
      k.across = limit * f.first_over_y;
      // a tenth of the secant: with none a sliding point would have no stiffness at all, and
      // Newton's step would carry it through the whole range where it sticks
      k.along = limit * (0.9 * f.second + 0.1 * f.first_over_y);
      for (double& d : k.direction) d = length > 0 ? d / length : 0;
    }
    active_.push_back(k);
    add_nodal(k);
  }
}

/// Row sums of one point's stiffness.
void Contact::add_nodal(const PointStiffness& k) {
  const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(k.point));
  for (int c = 0; c < 8; ++c) {
    const double w = std::abs(scene_.surface.weights(k.point, c));
    if (w == 0) continue;
    int32_t& place = stiff_place_[size_t(corners[c])];
    if (place < 0) {
      place = int32_t(stiff_nodes_.size());
      stiff_nodes_.push_back(corners[c]);
      stiff_blocks_.resize(stiff_blocks_.size() + 9);
    }
    double* block = stiff_blocks_.data() + 9 * size_t(place);
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j)
        block[3 * i + j] += w * ((i == j ? k.across : 0) +
                                 (k.normal - k.across) * floor_.normal[i] * floor_.normal[j] +
                                 (k.along - k.across) * k.direction[i] * k.direction[j]);
  }
}

void Contact::add_hessian_product(const float* p, float* f) const {
  const Vec3& n = floor_.normal;
  for (const PointStiffness& k : active_) {
    const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(k.point));
    const double* w = scene_.surface.weights.row(k.point);
    double d[3] = {}, normal = 0, along = 0;
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i) d[i] += w[c] * double(p[3 * int64_t(corners[c]) + i]);
    for (int i = 0; i < 3; ++i) {
      normal += d[i] * n[size_t(i)];
      along += d[i] * k.direction[i];
    }
    // normal n n^T + across (I - n n^T - t t^T) + along t t^T
    for (int i = 0; i < 3; ++i)
      d[i] = k.across * d[i] + (k.normal - k.across) * normal * n[size_t(i)] +
             (k.along - k.across) * along * k.direction[i];
    for (int c = 0; c < 8; ++c) {
      if (scene_.pinned(corners[c])) continue;
      for (int i = 0; i < 3; ++i) f[3 * int64_t(corners[c]) + i] += float(w[c] * d[i]);
    }
  }
}

double Contact::longest_step(const double* u, const double* end) const {
  double longest = 1;
  for (int64_t k = 0; k < points_; ++k) {
    const double approach = normal_motion(k, u) - normal_motion(k, end);
    if (approach <= 0) continue;
    const double distance = height(k) + normal_motion(k, u);
    if (0.9 * distance < longest * approach) longest = 0.9 * distance / approach;
  }
  return longest;
}

double Contact::deepest_overlap(const double* u) const {
  double deepest = 0;
  for (int64_t p = 0; p < points_; ++p)
    deepest = std::max(deepest, layer_ - height(p) - normal_motion(p, u));
  return deepest;
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "network/contact/contact.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"

#include <limits>

namespace elastogen {

Contact::Contact(const Scene& scene) : scene_(scene) {
  if (scene.colliders.empty()) return;
  const SurfacePoints& s = scene.surface;
  points_ = s.voxel.rows();
  ELASTOGEN_CHECK(points_ > 0, "a scene with a collider needs surface points");
  ELASTOGEN_CHECK(
      s.weights.rows() == points_ && s.area.rows() == points_ && s.position.rows() == points_,
      "the surface points' arrays differ in length");
  // lengths and obstacles, then arrays and stiffness of the points
  lengths_ = contact_lengths(scene);
  slip_range_ = lengths_.slip_range;
  for (const Collider& c : scene.colliders)
    obstacles_.push_back({{offset_at(c, 0), offset_at(c, 0)}, core_of(c, lengths_.layer)});
  const auto points = size_t(points_);
  lags_.resize(obstacles_.size() * points);
  for (std::vector<Vec3>* places : {&start_, &place_, &end_}) places->resize(points);
  near_.resize(points);
  boxes_.resize(size_t((points_ + kBlock - 1) / kBlock));
  stiffness_.resize(points);
  for (int64_t p = 0; p < points_; ++p) {
    const Material& m = scene.materials[size_t(scene.material(s.voxel(p)))];
    const double young = contact_young(m, scene.impact_speed);
    stiffness_[size_t(p)] = contact_stiffness(s.area(p) * young, lengths_.layer, scene.grid.h);
  }
  stiff_place_.assign(size_t(scene.grid.node_count()), -1);
  carried_.resize(size_t(scene.grid.node_count()));
}

/// Value at a point of a field of the nodes, (nodes, 3).
Vec3 Contact::carried(int64_t p, const double* values) const {
  const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
  const double* w = scene_.surface.weights.row(p);
  Vec3 sum = {};
  for (int c = 0; c < 8; ++c)
    for (size_t i = 0; i < 3; ++i) sum[i] += w[c] * values[3 * size_t(corners[c]) + i];
  return sum;
}

/// Position of a point [m].
Vec3 Contact::place_of(int64_t p, const double* u) const {
  Vec3 place = carried(p, u);
  for (size_t i = 0; i < 3; ++i) place[i] += scene_.surface.position(p, int(i));
  return place;
}

/// Positions of all points, and a ball about them.
Contact::Ball Contact::find_places(const double* u, std::vector<Vec3>& places) {
  for_blocks(points_, [&](int64_t begin, int64_t end) {
    Box& box = boxes_[size_t(begin / kBlock)] = {};
    for (int64_t p = begin; p < end; ++p) box.add(places[size_t(p)] = place_of(p, u));
  });
  Box all;
  for (const Box& box : boxes_) {
    all.add(box.lower);
    all.add(box.upper);
  }
  Ball ball;
  for (size_t d = 0; d < 3; ++d) ball.centre[d] = (all.lower[d] + all.upper[d]) / 2;
  ball.radius = std::hypot(all.extent(0), all.extent(1), all.extent(2)) / 2;
  return ball;
}

/// Whether a point of the body may be nearer to a core than `within`; distances are 1-Lipschitz, so
/// the ball around the body decides.
bool Contact::reaches(const Obstacle& obstacle, const Ball& body, double within) const {
  return !(proximity(obstacle.core, obstacle.to, body.centre).distance - body.radius > within);
}

void Contact::find_distances(const Obstacle& obstacle, const Vec3& offset) {
  for_each(points_, [&](int64_t p) {
    near_[size_t(p)] = proximity(obstacle.core, offset, place_[size_t(p)]);
  });
}

void Contact::begin_step(const double* u, double time, double dt) {
  if (!exists()) return;
  lengths_.slip_range = slip_range_ * (dt / scene_.dt);
  lengths_.bond = 0;
  dt_ = dt;
  find_places(u, place_);
  start_ = place_;
  start_time_ = time;
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    Obstacle& obstacle = obstacles_[w];
    obstacle.from = offset_at(obstacle.core, time);
    obstacle.to = offset_at(obstacle.core, time + dt);
    find_distances(obstacle, obstacle.from);
    ContactLag* lags = lags_.data() + w * size_t(points_);
    for_each(points_, [&](int64_t p) {
      lags[p] = contact_lag(near_[size_t(p)], stiffness_[size_t(p)], obstacle.core.friction,
                            lengths_.layer);
    });
    obstacle.rubs =
        std::any_of(lags, lags + points_, [](const ContactLag& l) { return l.limit > 0; });
  }
}

template <class T>
double Contact::evaluate(const double* u, T* g, bool at_pinned) {
  const Ball body = find_places(u, place_);
  double energy = 0;
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const Obstacle& obstacle = obstacles_[w];
    if (!obstacle.rubs && !reaches(obstacle, body, lengths_.layer)) continue;
    find_distances(obstacle, obstacle.to);
    for (int64_t p = 0; p < points_; ++p) {
      const Proximity& near = near_[size_t(p)];
      if (near.distance <= 0) return std::numeric_limits<double>::infinity();
      if (!touches(near, lag(w, p), lengths_.layer)) continue;
      Vec3 force;
      energy += point_energy(lengths_, point(w, p), obstacle, lag(w, p), near, force);
      if (!g) continue;
      const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
      const double* weights = scene_.surface.weights.row(p);
      for (int c = 0; c < 8; ++c) {
        if (!at_pinned && scene_.pinned(corners[c]) == kPinnedNode) continue;
        for (size_t i = 0; i < 3; ++i) g[3 * size_t(corners[c]) + i] += T(weights[c] * force[i]);
      }
    }
  }
  return energy;
}

template double Contact::evaluate(const double*, float*, bool);
template double Contact::evaluate(const double*, double*, bool);

ActionSums Contact::act(const double* u, const double* v, const double* v_stage,
                        const std::vector<Vec3>& about) {
  ActionSums sums;
  sums.pieces.resize(about.size());
  const Ball body = find_places(u, place_);
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const Obstacle& obstacle = obstacles_[w];
    if (!obstacle.rubs && !reaches(obstacle, body, lengths_.layer)) continue;
    const Vec3 speed = scaled(minus(obstacle.to, obstacle.from), 1 / dt_);
    find_distances(obstacle, obstacle.to);
    // the points that feel it
    for (int64_t p = 0; p < points_; ++p) {
      const Proximity& near = near_[size_t(p)];
      if (!touches(near, lag(w, p), lengths_.layer)) continue;
      const auto piece = size_t(scene_.grid.piece(scene_.grid.corners(scene_.surface.voxel(p), 0)));
      const PointSpeeds speeds = {minus(carried(p, v), speed), minus(carried(p, v_stage), speed),
                                  speed};
      const PointAction more = point_action(lengths_, point(w, p), obstacle, lag(w, p), near,
                                            obstacle.core.friction, about[piece], speeds);
      sums.pieces[piece].add(more.action);
      sums.energy += more.energy;
      sums.bonds += more.bond;
    }
  }
  return sums;
}

void Contact::linearise(const double* u) {
  for (const int32_t node : stiff_nodes_) stiff_place_[size_t(node)] = -1;
  stiff_nodes_.clear();
  stiff_blocks_.clear();
  active_.clear();
  const Ball body = find_places(u, place_);
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const Obstacle& obstacle = obstacles_[w];
    if (!obstacle.rubs && !reaches(obstacle, body, lengths_.layer)) continue;
    find_distances(obstacle, obstacle.to);
    for (int64_t p = 0; p < points_; ++p) {
      const Proximity& near = near_[size_t(p)];
      if (!touches(near, lag(w, p), lengths_.layer)) continue;
      active_.push_back({p, point_stiffness(lengths_, point(w, p), obstacle, lag(w, p), near)});
      add_nodal(active_.back());
    }
  }
}

/// Adds one point's stiffness to the row sums of its nodes.
void Contact::add_nodal(const Frozen& frozen) {
  const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(frozen.point));
  for (int c = 0; c < 8; ++c) {
    const double w = std::abs(scene_.surface.weights(frozen.point, c));
    if (w == 0) continue;
    int32_t& place = stiff_place_[size_t(corners[c])];
    if (place < 0) {
      place = int32_t(stiff_nodes_.size());
      stiff_nodes_.push_back(corners[c]);
      stiff_blocks_.resize(stiff_blocks_.size() + 9);
    }
    double* block = stiff_blocks_.data() + 9 * size_t(place);
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) block[3 * i + j] += w * frozen.k.entry(i, j);
  }
}

void Contact::add_hessian_product(const float* p, float* f) const {
  for (const auto& [point, k] : active_) {
    const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(point));
    const double* w = scene_.surface.weights.row(point);
    Vec3 d = {};
    for (int c = 0; c < 8; ++c)
      for (size_t i = 0; i < 3; ++i) d[i] += w[c] * double(p[3 * size_t(corners[c]) + i]);
    // normal n n^T + across (I - m m^T - t t^T) + along t t^T, m the normal at the step's start
    const double normal = k.normal * dot(d, k.n), lagged = k.across * dot(d, k.lagged);
    const double along = (k.along - k.across) * dot(d, k.direction);
    for (size_t i = 0; i < 3; ++i)
      d[i] = k.across * d[i] + normal * k.n[i] - lagged * k.lagged[i] + along * k.direction[i];
    for (int c = 0; c < 8; ++c) {
      if (scene_.pinned(corners[c]) == kPinnedNode) continue;
      for (size_t i = 0; i < 3; ++i) f[3 * size_t(corners[c]) + i] += float(w[c] * d[i]);
    }
  }
}

double Contact::longest_step(const double* u, const double* end) {
  const Ball from = find_places(u, place_), to = find_places(end, end_);
  double longest = 1;
  for (const Obstacle& obstacle : obstacles_) {
    // one ball holds all points on their paths
    const double way = std::hypot(to.centre[0] - from.centre[0], to.centre[1] - from.centre[1],
                                  to.centre[2] - from.centre[2]);
    const Ball swept = {from.centre, std::max(from.radius, way + to.radius)};
    if (!reaches(obstacle, swept, 0)) continue;
    for (size_t p = 0; p < size_t(points_); ++p)
      longest = std::min(longest, free_share(obstacle.core, obstacle.to, place_[p], end_[p],
                                             kLeastDistance * lengths_.layer));
  }
  return longest;
}

double Contact::deepest_overlap(const double* u) {
  const Ball body = find_places(u, place_);
  double deepest = 0;
  for (const Obstacle& obstacle : obstacles_) {
    if (!reaches(obstacle, body, lengths_.layer)) continue;
    find_distances(obstacle, obstacle.to);
    for (const Proximity& near : near_) deepest = std::max(deepest, lengths_.layer - near.distance);
  }
  return deepest;
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// A start value of a step that is clear of colliders which have moved.
#include "core/parallel.hpp"
#include "network/contact.hpp"

#include <cmath>

namespace elastogen {

/// Whether a wall's motion takes a point more than half of its distance; marks the nodes of all
/// points that it may reach.
bool Contact::crowds(const Wall& wall, double motion) {
  bool crowded = false;
  std::fill(carried_.begin(), carried_.end(), uint8_t(0));
  for (int64_t p = 0; p < points_; ++p) {
    const Vec3& place = place_[size_t(p)];
    const double before = proximity(wall.core, wall.from, place).distance;
    if (before >= motion + layer_) continue;
    const double after = proximity(wall.core, wall.to, place).distance;
    crowded |= after < layer_ && after < before / 2;
    const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
    for (int c = 0; c < 8; ++c) carried_[size_t(corners[c])] = 1;
  }
  return crowded;
}

/// Share of the wall's motion that a place near it makes: less where another wall is ahead. Those
/// before `wall` have moved already, those after it have not.
double Contact::carried_share(size_t wall, const Vec3& place, const Vec3& direction) const {
  const double own = std::max(proximity(walls_[wall].core, walls_[wall].from, place).distance, 0.0);
  double share = 1;
  for (size_t w = 0; w < walls_.size(); ++w) {
    if (w == wall) continue;
    const Proximity near =
        proximity(walls_[w].core, w < wall ? walls_[w].to : walls_[w].from, place);
    double ahead = 0;
    for (size_t d = 0; d < 3; ++d) ahead -= direction[d] * near.normal[d];
    const double other = std::max(near.distance, 0.0), sum = other + own * ahead;
    if (ahead > 0 && sum > 0) share = std::min(share, other / sum);
  }
  return share;
}

void Contact::carry(double* u) {
  const Array<double>& X = scene_.grid.rest;
  for (size_t w = 0; w < walls_.size(); ++w) {
    Vec3 way;
    for (size_t d = 0; d < 3; ++d) way[d] = walls_[w].to[d] - walls_[w].from[d];
    const double motion = std::hypot(way[0], way[1], way[2]);
    if (motion == 0) continue;
    find_places(u, place_);
    if (!crowds(walls_[w], motion)) continue;
    const Vec3 direction = {way[0] / motion, way[1] / motion, way[2] / motion};
    for_each(X.rows(), [&](int64_t n) {
      if (!carried_[size_t(n)] || scene_.pinned(n)) return;
      const Vec3 place = {X(n, 0) + u[3 * n], X(n, 1) + u[3 * n + 1], X(n, 2) + u[3 * n + 2]};
      const double share = carried_share(w, place, direction);
      for (size_t d = 0; d < 3; ++d) u[3 * size_t(n) + d] += share * way[d];
    });
  }
}

const Collider* Contact::obstacle(const double* u) {
  find_places(u, place_);
  for (size_t w = 0; w < walls_.size(); ++w)
    for (const Vec3& place : place_)
      if (!(proximity(walls_[w].core, walls_[w].to, place).distance > 0))
        return &scene_.colliders[w];
  return nullptr;
}

}  // namespace elastogen

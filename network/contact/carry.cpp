// SPDX-License-Identifier: Apache-2.0
// The start value of a step, moved clear of colliders that have moved.
#include "core/parallel.hpp"
#include "network/contact/contact.hpp"

#include <cmath>

namespace elastogen {

/// Whether the motion of a collider halves its distance to some point; marks the nodes of all
/// points that the collider may reach.
bool Contact::crowds(const Obstacle& obstacle, double motion) {
  bool found = false;
  std::fill(carried_.begin(), carried_.end(), uint8_t(0));
  for (int64_t p = 0; p < points_; ++p) {
    const Vec3& place = place_[size_t(p)];
    const double before = proximity(obstacle.core, obstacle.from, place).distance;
    if (before >= motion + lengths_.layer) continue;
    const double after = proximity(obstacle.core, obstacle.to, place).distance;
    found |= crowded(before, after, lengths_.layer);
    const int32_t* corners = scene_.grid.corners.row(scene_.surface.voxel(p));
    for (int c = 0; c < 8; ++c) carried_[size_t(corners[c])] = 1;
  }
  return found;
}

void Contact::carry(double* u) {
  const Array<double>& X = scene_.grid.rest;
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    Vec3 path;
    for (size_t d = 0; d < 3; ++d) path[d] = obstacles_[w].to[d] - obstacles_[w].from[d];
    const double motion = std::hypot(path[0], path[1], path[2]);
    if (motion == 0) continue;
    find_places(u, place_);
    if (!crowds(obstacles_[w], motion)) continue;
    const Vec3 direction = {path[0] / motion, path[1] / motion, path[2] / motion};
    for_each(X.rows(), [&](int64_t n) {
      if (!carried_[size_t(n)] || scene_.pinned(n)) return;
      const Vec3 place = {X(n, 0) + u[3 * n], X(n, 1) + u[3 * n + 1], X(n, 2) + u[3 * n + 2]};
      const double share = carried_share(obstacles_.data(), obstacles_.size(), w, place, direction);
      for (size_t d = 0; d < 3; ++d) u[3 * size_t(n) + d] += share * path[d];
    });
  }
}

const Collider* Contact::obstacle(const double* u) {
  find_places(u, place_);
  for (size_t w = 0; w < obstacles_.size(); ++w)
    for (const Vec3& place : place_)
      if (!(proximity(obstacles_[w].core, obstacles_[w].to, place).distance > 0))
        return &scene_.colliders[w];
  return nullptr;
}

}  // namespace elastogen

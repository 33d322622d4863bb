// SPDX-License-Identifier: Apache-2.0
// Start and end of steps clear of colliders that have moved: carry.cpp on the device.
#include "core/cuda/held_nodes.cuh"
#include "network/contact/contact.cuh"

namespace elastogen::cuda {

/// Positions of the colliders at the start and at the end of a step, and at the time of the lag.
void DeviceContact::Impl::place_obstacles(double time, double dt, double lag_time) {
  for (size_t w = 0; w < cores.size(); ++w) {
    host_obstacles[w].from = offset_at(cores[w], time);
    host_obstacles[w].to = offset_at(cores[w], time + dt);
    host_obstacles[w].lag = offset_at(cores[w], lag_time);
  }
  obstacles.upload(host_obstacles.data());
}

void DeviceContact::Impl::take_lags(const double* u) {
  const ContactView v = view();
  cuda::for_each(v.points, [=] __device__(int64_t p) {
    const Vec3 place = v.start[p] = v.place(p, u);
    for (int w = 0; w < v.obstacle_count; ++w)
      v.lags[w * v.points + p] =
          contact_lag(proximity(v.obstacles[w].core, v.obstacles[w].from, place), v.stiffness[p],
                      v.obstacles[w].friction, v.lengths.layer);
  });
}

void DeviceContact::begin_step(const double* u, double time) {
  impl_->place_obstacles(time, impl_->scene.dt, time);
  impl_->take_lags(u);
}

/// Whether the motion of a collider halves its distance to some point; marks the nodes of all
/// points that the collider may reach.
bool DeviceContact::Impl::crowds(int obstacle, const double* u, double motion) {
  const ContactView v = view();
  uint8_t* mark = carried.data();
  ContactNumbers* to = numbers.data();
  check(cudaMemsetAsync(mark, 0, size_t(carried.size()), cudaStreamPerThread));
  ordered_sum(
      v.points, crowd_sums.data(),
      [=] __device__(int64_t p, Sums<1> & sum) {
        const Vec3 place = v.place(p, u);
        const DeviceObstacle& of = v.obstacles[obstacle];
        const double before = proximity(of.core, of.from, place).distance;
        if (before >= motion + v.lengths.layer) return;
        const double after = proximity(of.core, of.to, place).distance;
        sum.value[0] += crowded(before, after, v.lengths.layer) ? 1 : 0;
        for (int c = 0; c < 8; ++c) mark[v.corners[8 * p + c]] = 1;
      },
      [=] __device__(const Sums<1>& sum) { to->crowded = sum.value[0]; });
  synchronise();
  return numbers[0].crowded > 0;
}

/// Moves the marked nodes along with a collider.
void DeviceContact::Impl::carry_along(int obstacle, const Vec3& motion, double size, double* u) {
  const ContactView v = view();
  const double* X = rest.data();
  const uint8_t *mark = carried.data(), *held = pinned.data();
  const Vec3 direction = {motion[0] / size, motion[1] / size, motion[2] / size};
  cuda::for_each(carried.size(), [=] __device__(int64_t n) {
    if (!mark[n] || held[n]) return;
    Vec3 place;
    for (int d = 0; d < 3; ++d) place[d] = X[3 * n + d] + u[3 * n + d];
    const double share =
        carried_share(v.obstacles, size_t(v.obstacle_count), size_t(obstacle), place, direction);
    for (int d = 0; d < 3; ++d) u[3 * n + d] += share * motion[d];
  });
}

void DeviceContact::Impl::carry(double* u) {
  for (size_t w = 0; w < host_obstacles.size(); ++w) {
    const Vec3 motion = minus(host_obstacles[w].to, host_obstacles[w].from);
    const double size = safe_norm(motion);
    if (size == 0 || !crowds(int(w), u, size)) continue;
    carry_along(int(w), motion, size, u);
  }
}

/// Finds the share of the straight path from u to `end` that all points allow, and a collider whose
/// core contains a point at u.
void DeviceContact::Impl::sweep(const double* u, const double* end) {
  const ContactView v = view();
  Sweep* on_device = swept.data();
  ContactNumbers* to = numbers.data();
  ordered_sum(
      v.points, sweep_sums.data(),
      [=] __device__(int64_t p, Sweep & found) {
        const Vec3 a = v.place(p, u), b = v.place(p, end);
        for (int w = 0; w < v.obstacle_count; ++w) {
          const DeviceObstacle& of = v.obstacles[w];
          const double share = free_share(of.core, of.to, a, b, kLeastDistance * v.lengths.layer);
          const bool outside = proximity(of.core, of.to, a).distance > 0;
          found.add({share, outside ? 1e300 : double(w)});
        }
      },
      [=] __device__(const Sweep& found) { *on_device = to->swept = found; });
}

void DeviceContact::cut_step(const double* u, double* end) {
  impl_->sweep(u, end);
  const Sweep* swept = impl_->swept.data();
  cuda::for_each(3 * impl_->scene.grid.node_count(), [=] __device__(int64_t k) {
    if (swept->share < 1) end[k] = u[k] + swept->share * (end[k] - u[k]);
  });
}

double DeviceContact::share() const {
  return impl_->numbers[0].swept.share;
}

const Collider* DeviceContact::clear_start(const double* now, double* clear, double* u,
                                           const DeviceHeldNodes& held) {
  const Scene& scene = impl_->scene;
  check(cudaMemcpyAsync(clear, now, 3 * size_t(scene.grid.node_count()) * sizeof(double),
                        cudaMemcpyDeviceToDevice, cudaStreamPerThread));
  impl_->carry(clear);
  held.follow(clear);
  cut_step(clear, u);
  synchronise();
  const double inside = impl_->numbers[0].swept.inside;
  return inside < 1e300 ? &scene.colliders[size_t(inside)] : nullptr;
}

}  // namespace elastogen::cuda

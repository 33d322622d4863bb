// SPDX-License-Identifier: Apache-2.0
// friction.cpp on the device: friction as a bond of each point to each collider, and what colliders do
// to the pieces.
#include "core/parallel.hpp"
#include "network/contact/contact.cuh"

namespace elastogen::cuda {
namespace {

/// Surface points of each piece.
std::vector<std::vector<int32_t>> points_of_pieces(const Scene& scene) {
  return grouped(scene.surface.voxel.rows(), size_t(scene.grid.pieces), [&](int64_t p) {
    return scene.grid.piece(scene.grid.corners(scene.surface.voxel(p), 0));
  });
}

}  // namespace

ContactBonds::ContactBonds(const Scene& scene)
    : held(int64_t(scene.colliders.size()) * scene.surface.voxel.rows()),
      slip(held.size()),
      last_lags(held.size()),
      sums(1),
      pieces(points_of_pieces(scene)),
      about(pieces.count()),
      parts(pieces.chunks()),
      actions(pieces.count()) {}

/// Sets the lag of friction from displacements u, colliders at their places for it, and what the
/// bonds hold by it. Counts the points that rub.
void DeviceContact::Impl::set_lags(const double* u) {
  const ContactView v = view();
  const Vec3* const held = bonds->held.data();
  ContactNumbers* to = numbers.data();
  ordered_sum(
      v.points, bonds->sums.data(),
      [=] __device__(int64_t p, Sums<1> & sum) {
        const Vec3 place = v.place(p, u);
        for (int w = 0; w < v.obstacle_count; ++w) {
          const DeviceObstacle& of = v.obstacles[w];
          const int64_t k = w * v.points + p;
          const ContactLag lag = contact_lag(proximity(of.core, of.lag, place), v.stiffness[p],
                                             of.friction, v.lengths.layer);
          v.lags[k] = lag;
          v.slip[k] = bonded_slip(v.lengths, v.stiffness[p], lag, held[k]);
          sum.value[0] += lag.limit > 0 ? 1 : 0;
        }
      },
      [=] __device__(const Sums<1>& sum) { to->rubbing = sum.value[0]; });
}

void DeviceContact::begin_stage(const double* u, double time, double dt, const double* of_lag,
                                double lag_time) {
  Impl& s = *impl_;
  s.lengths.bond = kBond / (s.lengths.layer * s.lengths.layer);
  s.bonds->end_time = time + dt;
  s.bonds->per_dt = 1 / dt;
  s.place_obstacles(time, dt, lag_time);
  const ContactView v = s.view();
  cuda::for_each(v.points, [=] __device__(int64_t p) { v.start[p] = v.place(p, u); });
  s.set_lags(of_lag);
}

bool DeviceContact::renew_lag(const double* u) {
  Impl& s = *impl_;
  for (size_t w = 0; w < s.cores.size(); ++w) s.host_obstacles[w].lag = s.host_obstacles[w].to;
  s.obstacles.upload(s.host_obstacles.data());  // waits, so that the count is complete
  const bool rubbed = s.numbers[0].rubbing > 0;
  check(cudaMemcpyAsync(s.bonds->last_lags.data(), s.lags.data(),
                        size_t(s.lags.size()) * sizeof(ContactLag), cudaMemcpyDeviceToDevice,
                        cudaStreamPerThread));
  s.set_lags(u);
  synchronise();
  return rubbed || s.numbers[0].rubbing > 0;
}

void DeviceContact::relax_lag(double share) {
  const ContactView v = impl_->view();
  const ContactLag* const last = impl_->bonds->last_lags.data();
  const Vec3* const held = impl_->bonds->held.data();
  cuda::for_each(v.points, [=] __device__(int64_t p) {
    for (int w = 0; w < v.obstacle_count; ++w) {
      const int64_t k = w * v.points + p;
      v.lags[k] = relaxed_lag(last[k], v.lags[k], share);
      v.slip[k] = bonded_slip(v.lengths, v.stiffness[p], v.lags[k], held[k]);
    }
  });
}

void DeviceContact::keep_bonds(const double* u) {
  const ContactView v = impl_->view();
  Vec3* const held = impl_->bonds->held.data();
  cuda::for_each(v.points, [=] __device__(int64_t p) {
    const ContactPoint point = v.point(p, u);
    for (int w = 0; w < v.obstacle_count; ++w) {
      const DeviceObstacle& of = v.obstacles[w];
      held[w * v.points + p] = kept_slip(v.lengths, v.bonded(point, w, p), of, v.lag(w, p),
                                         proximity(of.core, of.to, point.place), of.friction);
    }
  });
}

void DeviceContact::forget_bonds() {
  DeviceArray<Vec3>& held = impl_->bonds->held;
  check(cudaMemsetAsync(held.data(), 0, size_t(held.size()) * sizeof(Vec3), cudaStreamPerThread));
}

void DeviceContact::download_bonds(Array<double>& bonds) const {
  const DeviceArray<Vec3>& held = impl_->bonds->held;
  if (bonds.rows() != held.size()) bonds = Array<double>(held.size(), 3);
  check(cudaMemcpy(bonds.data(), held.data(), size_t(held.size()) * sizeof(Vec3),
                   cudaMemcpyDeviceToHost));
}

/// Adds up what colliders do to the points of each piece.
void DeviceContact::Impl::sum_actions(const double* u, const double* start, const double* stage) {
  const ContactView v = view();
  const Vec3* const about = bonds->about.data();
  const double per_dt = bonds->per_dt;
  ContactBonds::Action* const to = bonds->actions.data();
  bonds->pieces.sums(
      bonds->parts,
      [=] __device__(int64_t piece, int64_t p, ContactBonds::Action & sum) {
        const ContactPoint point = v.point(p, u);
        for (int w = 0; w < v.obstacle_count; ++w) {
          const DeviceObstacle& of = v.obstacles[w];
          const Proximity near = proximity(of.core, of.to, point.place);
          const ContactLag& lag = v.lag(w, p);
          if (!touches(near, lag, v.lengths.layer)) continue;
          const Vec3 speed = scaled(minus(of.to, of.from), per_dt);
          const PointSpeeds speeds = {minus(v.carried(p, start), speed),
                                      minus(v.carried(p, stage), speed), speed};
          const PointAction more = point_action(v.lengths, v.bonded(point, w, p), of, lag, near,
                                                of.friction, about[piece], speeds);
          // in the order in which act() reads them
          for (int i = 0; i < 3; ++i) {
            sum.value[i] += more.action.force[i];
            sum.value[3 + i] += more.action.torque[i];
          }
          sum.value[6] += more.action.normal;
          sum.value[7] += more.action.power;
          sum.value[8] += more.action.rubbed;
          sum.value[9] += more.action.driven;
          sum.value[10] += more.energy;
          sum.value[11] += more.bond;
        }
      },
      [=] __device__(int64_t piece, const ContactBonds::Action& sum) { to[piece] = sum; });
}

ActionSums DeviceContact::act(const double* u, const double* v, const double* v_stage,
                              const std::vector<Vec3>& about) {
  Impl& s = *impl_;
  s.bonds->about.upload(about.data());
  s.sum_actions(u, v, v_stage);
  synchronise();
  // as the host has them
  ActionSums result;
  for (size_t p = 0; p < about.size(); ++p) {
    const double* sum = s.bonds->actions[int64_t(p)].value;
    result.pieces.push_back(
        {{sum[0], sum[1], sum[2]}, {sum[3], sum[4], sum[5]}, sum[6], sum[7], sum[8], sum[9]});
    result.energy += sum[10];
    result.bonds += sum[11];
  }
  return result;
}

}  // namespace elastogen::cuda

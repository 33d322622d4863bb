// SPDX-License-Identifier: Apache-2.0
#include "network/contact/contact.cuh"

#include <limits>

namespace elastogen::cuda {
namespace {

std::vector<double> numbers_of(const Array<double>& array) {
  return {array.data(), array.data() + array.size()};
}

std::vector<int32_t> corners_of_points(const Scene& scene) {
  std::vector<int32_t> corners;
  for (int64_t p = 0; p < scene.surface.voxel.rows(); ++p) {
    const int32_t* of = scene.grid.corners.row(scene.surface.voxel(p));
    corners.insert(corners.end(), of, of + 8);
  }
  return corners;
}

bool have_paths(const std::vector<Collider>& colliders) {
  return std::any_of(colliders.begin(), colliders.end(),
                     [](const Collider& c) { return !c.path.keys.empty(); });
}

}  // namespace

DeviceContact::Impl::Impl(const PotentialTerms& host)
    : scene(host.scene()),
      lengths(host.contact().lengths()),
      moving(have_paths(scene.colliders)),
      corners(corners_of_points(scene)),
      weights(numbers_of(scene.surface.weights)),
      position(numbers_of(scene.surface.position)),
      stiffness(host.contact().stiffness()),
      obstacles(int64_t(scene.colliders.size())),
      lags(obstacles.size() * stiffness.size()),
      start(stiffness.size()),
      force(stiffness.size()),
      frozen(6 * stiffness.size()),
      touched(1),
      energy_sums(1),
      sweep_sums(1),
      crowd_sums(1),
      swept(1),
      numbers(1) {
  // the cores of the colliders, which begin at rest
  for (const Collider& c : scene.colliders) {
    cores.push_back(core_of(c, lengths.layer));
    host_obstacles.push_back({{}, cores.back(), c.friction});
  }
  at_free = list_entries(false, surface_nodes);
  blocks = DeviceArray<double>(6 * at_free.nodes.size());
  std::vector<int32_t> held;
  if (!scene.holder.empty()) at_pinned = list_entries(true, held);
  if (has_stages(scene.scheme)) bonds.emplace(scene);
  // nodes move along only with colliders that move
  if (!moving) return;
  rest = DeviceArray<double>(numbers_of(scene.grid.rest));
  pinned = DeviceArray<uint8_t>(
      std::vector<uint8_t>(scene.pinned.data(), scene.pinned.data() + scene.pinned.rows()));
  carried = DeviceArray<uint8_t>(pinned.size());
}

/// Lists the points of each surface node that is pinned or is not, in the order of the points.
/// @param listed  gets these nodes.
GatherLists DeviceContact::Impl::list_entries(bool of_pinned, std::vector<int32_t>& listed) const {
  const Array<double>& w = scene.surface.weights;
  // body(point, node, weight) for every weight of such a node
  const auto for_entries = [&](const auto& body) {
    for (int64_t p = 0; p < w.rows(); ++p)
      for (int c = 0; c < 8; ++c) {
        const int32_t node = scene.grid.corners(scene.surface.voxel(p), c);
        const bool is_pinned = scene.pinned(node) == kPinnedNode;
        if (w(p, c) != 0 && is_pinned == of_pinned) body(p, node, w(p, c));
      }
  };
  // nodes with points are surface nodes; the sums of counts are where their lists begin
  std::vector<int32_t> count(size_t(scene.grid.node_count())), next(count.size());
  for_entries([&](int64_t, int32_t node, double) { ++count[size_t(node)]; });
  std::vector<int32_t> first = {0};
  for (size_t n = 0; n < count.size(); ++n) {
    next[n] = first.back();
    if (count[n] == 0) continue;
    listed.push_back(int32_t(n));
    first.push_back(first.back() + count[n]);
  }
  // fill the lists point by point
  std::vector<int32_t> points(size_t(first.back()));
  std::vector<double> values(points.size());
  for_entries([&](int64_t p, int32_t node, double value) {
    const auto k = size_t(next[size_t(node)]++);
    points[k] = int32_t(p), values[k] = value;
  });
  return {DeviceArray<int32_t>(listed), DeviceArray<int32_t>(first), DeviceArray<int32_t>(points),
          DeviceArray<double>(values)};
}

/// Adds the points' forces to the nodes, unless all are 0.
template <class T>
void DeviceContact::Impl::gather_forces(const GatherLists& lists, T* to) const {
  const GatherView g = lists.view();
  const Vec3* of = force.data();
  const int32_t* any = touched.data();
  cuda::for_each(g.count, [=] __device__(int64_t s) {
    if (*any == 0) return;
    double sum[3] = {};
    for (int32_t k = g.begin[s]; k < g.begin[s + 1]; ++k)
      for (int i = 0; i < 3; ++i) sum[i] += g.weight[k] * of[g.point[k]][i];
    for (int i = 0; i < 3; ++i) to[3 * int64_t(g.nodes[s]) + i] += T(sum[i]);
  });
}

DeviceContact::DeviceContact(const PotentialTerms& host) : impl_(std::make_unique<Impl>(host)) {}

DeviceContact::~DeviceContact() = default;

template <class T>
void DeviceContact::start_evaluation(const double* u, T* g) {
  const ContactView v = impl_->view();
  Vec3* forces = impl_->force.data();
  int32_t* any = impl_->touched.data();
  ContactNumbers* to = impl_->numbers.data();
  // energy and force of each point over all colliders; infinite inside a core
  ordered_sum(
      v.points, impl_->energy_sums.data(),
      [=] __device__(int64_t p, ContactSums & sum) {
        const ContactPoint point = v.point(p, u);
        Vec3 all = {};
        for (int w = 0; w < v.obstacle_count; ++w) {
          const Proximity near = proximity(v.obstacles[w].core, v.obstacles[w].to, point.place);
          const ContactLag& lag = v.lag(w, p);
          if (near.distance <= 0) sum.energy = std::numeric_limits<double>::infinity();
          sum.add({0, v.lengths.layer - near.distance});
          if (!touches(near, lag, v.lengths.layer)) continue;
          Vec3 one;
          sum.energy +=
              point_energy(v.lengths, v.bonded(point, w, p), v.obstacles[w], lag, near, one);
          for (int i = 0; i < 3; ++i) all[i] += one[i];
        }
        forces[p] = all;
      },
      [=] __device__(const ContactSums& sum) { to->sums = sum, *any = sum.energy != 0; });
  // nodes gather the forces of their points
  if (g) impl_->gather_forces(impl_->at_free, g);
}

void DeviceContact::add_pinned_forces(double* g) {
  impl_->gather_forces(impl_->at_pinned, g);
}

double DeviceContact::energy() const {
  return impl_->numbers[0].sums.energy;
}

double DeviceContact::deepest_overlap() const {
  return impl_->numbers[0].sums.deepest;
}

void DeviceContact::linearise(const double* u, bool touching) {
  impl_->stiff = touching;
  if (!touching) return;
  const ContactView v = impl_->view();
  double* to = impl_->frozen.data();
  cuda::for_each(v.points, [=] __device__(int64_t p) {
    const ContactPoint point = v.point(p, u);
    double sum[6] = {};
    for (int w = 0; w < v.obstacle_count; ++w) {
      const Proximity near = proximity(v.obstacles[w].core, v.obstacles[w].to, point.place);
      const ContactLag& lag = v.lag(w, p);
      if (!touches(near, lag, v.lengths.layer)) continue;
      const PointStiffness k =
          point_stiffness(v.lengths, v.bonded(point, w, p), v.obstacles[w], lag, near);
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) sum[symmetric_place(i, j)] += k.entry(i, j);
    }
    for (int k = 0; k < 6; ++k) to[6 * p + k] = sum[k];
  });
}

bool DeviceContact::is_stiff() const {
  return impl_->stiff;
}

template <class T>
void DeviceContact::add_hessian_product(const T* p, T* f) {
  if (!impl_->stiff) return;
  const ContactView v = impl_->view();
  const double* frozen = impl_->frozen.data();
  Vec3* forces = impl_->force.data();
  int32_t* any = impl_->touched.data();
  cuda::for_each(v.points, [=] __device__(int64_t n) {
    const double* K = frozen + 6 * n;
    Vec3 d = {}, force = {};
    bool stiff = false;
    for (int k = 0; k < 6; ++k) stiff |= K[k] != 0;
    for (int c = 0; stiff && c < 8; ++c)
      for (int i = 0; i < 3; ++i)
        d[i] += v.weights[8 * n + c] * double(p[3 * int64_t(v.corners[8 * n + c]) + i]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) force[i] += K[symmetric_place(i, j)] * d[j];
    forces[n] = force;
    if (n == 0) *any = 1;
  });
  impl_->gather_forces(impl_->at_free, f);
}

NodalStiffness DeviceContact::nodal_stiffness(const Quaternion<float>* rotation,
                                              const uint8_t* pinned, const double* share) {
  const GatherView g = impl_->at_free.view();
  const double* frozen = impl_->frozen.data();
  double* to = impl_->blocks.data();
  cuda::for_each(g.count, [=] __device__(int64_t s) {
    if (pinned[g.nodes[s]]) return;  // the block stays 0
    double sum[6] = {};
    for (int32_t k = g.begin[s]; k < g.begin[s + 1]; ++k)
      for (int m = 0; m < 6; ++m) sum[m] += fabs(g.weight[k]) * frozen[6 * int64_t(g.point[k]) + m];
    const Mat3<float> turn = rotation_matrix(rotation[g.nodes[s]]);
    Mat3<double> R, K;
    for (int m = 0; m < 9; ++m) R.m[m] = double(turn.m[m]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) K(i, j) = sum[symmetric_place(i, j)];
    const Mat3<double> turned = transposed_times(R, K * R);
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) to[6 * s + symmetric_place(i, j)] = *share * turned(i, j);
  });
  return {g.nodes, to, g.count};
}

FrozenStiffness DeviceContact::frozen_stiffness() {
  const GatherView g = impl_->at_free.view();
  const ContactView v = impl_->view();
  return {g.nodes,
          g.begin,
          g.point,
          g.weight,
          impl_->stiff ? g.count : 0,
          v.corners,
          v.weights,
          impl_->frozen.data()};
}

const std::vector<int32_t>& DeviceContact::surface_nodes() const {
  return impl_->surface_nodes;
}

template void DeviceContact::start_evaluation(const double*, float*);
template void DeviceContact::start_evaluation(const double*, double*);
template void DeviceContact::add_hessian_product(const float*, float*);
template void DeviceContact::add_hessian_product(const double*, double*);

}  // namespace elastogen::cuda

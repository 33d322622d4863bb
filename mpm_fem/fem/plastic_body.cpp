// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/plastic_body.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/fem/inversion_bound.hpp"
#include "mpm_fem/fem/positive_part.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Share s of the mean in the dilatation of elements with mean dilatation. A point's own dilatation
/// meets (1 - s)^2 K. Without that a point that flows could be flattened at almost no cost; this
/// much bears three times the yield stress, the pressure under a stamp, at a dilatation of a fifth.
double mean_share(const Solid& solid) {
  constexpr double kLeast = 0.1, kStiffness = 15;
  const auto* metal = std::get_if<MetalYield>(&solid.yield);
  if (!metal) return 1 - kLeast;
  const double ratio = kStiffness * metal->stress / bulk_modulus(solid.elastic, 3);
  return 1 - std::clamp(std::sqrt(ratio), kLeast, 1.0);
}

template <class Point>
void store(int64_t k, const Point& point, PlasticHistory& history) {
  std::copy_n(point.Fp_inverse.m, 9, history.Fp_inverse.row(k));
  history.memory(k) = memory_of(point.history);
}

template <class Point>
using LawOf = std::decay_t<decltype(std::declval<Point>().law)>;
template <class Point>
constexpr bool kHasEnergy = elastogen::has_energy<LawOf<Point>>;

}  // namespace

PlasticBody::PlasticBody(const ElementMesh& mesh, const std::vector<Solid>& solids)
    : tables_(mesh), solids_(solids) {
  ELASTOGEN_CHECK(mesh.element != Element::kVoxel,
                  "voxel elements cannot yield: their one point leaves the flow to an elastic term;"
                  " take hex-bbar");
  for (const Solid& solid : solids_) {
    laws_.push_back(any_law(solid, is_plane(mesh.element)));
    shares_.push_back(mean_share(solid));
  }
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    ELASTOGEN_CHECK(mesh.material(e) >= 0 && mesh.material(e) < int(solids_.size()), "element ", e,
                    " has material ", mesh.material(e), " of ", solids_.size());
  history_ = rest_history();
}

bool PlasticBody::has_energy() const {
  return std::all_of(laws_.begin(), laws_.end(), [](const AnyLaw& law) {
    return std::visit([]<class L>(const L&) { return elastogen::has_energy<L>; }, law);
  });
}

PlasticHistory PlasticBody::rest_history() const {
  const int64_t points = mesh().elements.rows() * tables_.points();
  PlasticHistory history{Array<double>(points, 9), Array<double>(points)};
  for (int64_t k = 0; k < points; ++k)
    for (int d = 0; d < 3; ++d) history.Fp_inverse(k, 4 * d) = 1;
  return history;
}

void PlasticBody::set_history(const PlasticHistory& history) {
  const int64_t points = mesh().elements.rows() * tables_.points();
  ELASTOGEN_CHECK(
      In<double>(history.Fp_inverse).is(points, 9) && In<double>(history.memory).is(points, 1),
      "a plastic history must be (", points, ", 9) and (", points, ", 1)");
  history_ = history;
  thaw();
}

/// Calls visit(q, PlasticPoint) with the true law of each point of an element.
template <class Visit>
void PlasticBody::for_laws(int64_t element, const Visit& visit) const {
  const auto at = [&](const auto& law) {
    for (int q = 0; q < tables_.points(); ++q) {
      const int64_t k = element * tables_.points() + q;
      Mat3<double> Fp_inverse;
      std::copy_n(history_.Fp_inverse.row(k), 9, Fp_inverse.m);
      visit(q, PlasticPoint<std::decay_t<decltype(law)>>{law, history_of(law, history_.memory(k)),
                                                         Fp_inverse});
    }
  };
  std::visit(at, laws_[size_t(mesh().material(element))]);
}

/// for_laws with the frozen potentials, if there are any.
template <class Visit>
void PlasticBody::for_points(int64_t element, const Visit& visit) const {
  if (frozen_.empty()) return for_laws(element, visit);
  for_laws(element, [&]<class Point>(int q, const Point& point) {
    const Frozen& frozen = frozen_[size_t(element * tables_.points() + q)];
    if constexpr (kHasEnergy<Point>) {
      visit(q, point);
    } else {
      using Law = FrozenLaw<LawOf<Point>>;
      const Law law{point.law};
      visit(q, PlasticPoint<Law>{law, std::get<typename Law::History>(frozen), point.Fp_inverse});
    }
  });
}

void PlasticBody::freeze(In<double> u) {
  tables_.check_nodal(u);
  if (has_energy()) return;
  std::vector<Frozen> frozen(size_t(history_.memory.rows()));
  for_each(
      mesh().elements.rows(),
      [&](int64_t element) {
        const PointGradients points(mesh().element, tables_.state(element, u), share(element));
        for_laws(element, [&]<class Point>(int q, const Point& point) {
          if constexpr (!kHasEnergy<Point>)
            frozen[size_t(element * tables_.points() + q)] =
                FrozenLaw<LawOf<Point>>{point.law}.frozen(point.elastic(points.F(q)).sigma,
                                                          point.history);
        });
      },
      kElementBlock);
  frozen_ = std::move(frozen);
}

double PlasticBody::energy(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> energy(mesh().elements.rows());
  for_each(
      energy.rows(),
      [&](int64_t element) {
        const ElementState e = tables_.state(element, u);
        const PointGradients points(mesh().element, e, share(element));
        for_points(element, [&](int q, const auto& point) {
          energy(element) += e.weight[q] * point.energy(points.F(q));
        });
      },
      kElementBlock);
  return total(energy);
}

void PlasticBody::add_gradient(In<double> u, Out<double> g) const {
  tables_.check_nodal(u);
  tables_.check_nodal(g);
  tables_.add_forces(
      [&](int64_t element, double* f) {
        const ElementState e = tables_.state(element, u);
        const PointGradients points(mesh().element, e, share(element));
        Mat3<double> P[kMaxPoints];
        for_points(element, [&](int q, const auto& point) { P[q] = point.stress(points.F(q)); });
        points.add_force(e, P, f);
      },
      g);
}

void PlasticBody::add_gradient_and_commit(In<double> u, Out<double> g) {
  tables_.check_nodal(u);
  tables_.check_nodal(g);
  tables_.add_forces(
      [&](int64_t element, double* f) {
        const ElementState e = tables_.state(element, u);
        const PointGradients points(mesh().element, e, share(element));
        Mat3<double> P[kMaxPoints];
        for_laws(element, [&](int q, auto point) {
          P[q] = point.stress(points.F(q));
          point.commit(points.F(q));
          store(element * tables_.points() + q, point, history_);
        });
        points.add_force(e, P, f);
      },
      g);
}

void PlasticBody::element_hessian(int64_t element, In<double> u, TangentKind kind,
                                  double* K) const {
  tables_.check_nodal(u);
  const ElementState e = tables_.state(element, u);
  const PointGradients points(mesh().element, e, share(element));
  const bool shares = points.shares_dilatation();
  bool symmetric = true;
  Mat3<double> P[kMaxPoints];
  double A[81 * kMaxPoints];
  for_points(element, [&](int q, const auto& point) {
    symmetric &= elastogen::has_energy<std::decay_t<decltype(point.law)>>;
    if (shares) P[q] = point.stress(points.F(q));
    point.tangent(points.F(q), shares ? TangentKind::kTrue : kind, A + 81 * q);
  });
  points.stiffness(e, P, A, symmetric, K);
  if (kind == TangentKind::kProjected && shares && symmetric) clamp_eigenvalues(3 * e.nodes, K);
}

PlasticHistory PlasticBody::history_after(In<double> u) const {
  tables_.check_nodal(u);
  PlasticHistory after = history_;
  for_each(mesh().elements.rows(), [&](int64_t element) {
    const PointGradients points(mesh().element, tables_.state(element, u), share(element));
    for_laws(element, [&](int q, auto point) {
      point.commit(points.F(q));
      store(element * tables_.points() + q, point, after);
    });
  });
  return after;
}

StepWork PlasticBody::work(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> elastic(mesh().elements.rows()), plastic(elastic);
  for_each(elastic.rows(), [&](int64_t element) {
    const ElementState e = tables_.state(element, u);
    const PointGradients points(mesh().element, e, share(element));
    for_laws(element, [&](int q, const auto& point) {
      const StepWork work = point.work(points.F(q));
      elastic(element) += e.weight[q] * work.elastic;
      plastic(element) += e.weight[q] * work.plastic;
    });
  });
  return {total(elastic), total(plastic)};
}

double PlasticBody::min_j(In<double> u) const {
  tables_.check_nodal(u);
  Array<double> smallest(mesh().elements.rows());
  for_each(smallest.rows(), [&](int64_t element) {
    const ElementState e = tables_.state(element, u);
    smallest(element) = determinant(deformation_gradient(e, 0));
    for (int q = 1; q < e.points; ++q)
      smallest(element) = std::min(smallest(element), determinant(deformation_gradient(e, q)));
  });
  return *std::min_element(smallest.data(), smallest.data() + smallest.size());
}

double PlasticBody::longest_step(In<double> u, In<double> end) const {
  Array<double> share(mesh().elements.rows());
  for_each(share.rows(), [&](int64_t element) {
    const ElementState e = tables_.state(element, u), there = tables_.state(element, end);
    share(element) = 1;
    for (int q = 0; q < e.points; ++q)
      share(element) = std::min(
          share(element),
          share_before_inversion(deformation_gradient(e, q), deformation_gradient(there, q)));
  });
  return *std::min_element(share.data(), share.data() + share.size());
}

double PlasticBody::stiffness(int64_t element) const {
  const Material& m = solids_[size_t(mesh().material(element))].elastic;
  return 2 * m.mu() + m.lambda();
}

}  // namespace elastogen::fem

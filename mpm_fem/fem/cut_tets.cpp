// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/cut_tets.hpp"

#include "core/base.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/mesh_part.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr double kNothing = 1e-9;  // free share of an element that is none
constexpr int kHalvings = 3;       // of edges, for borders that are no planes

/// A tetrahedron in the reference element.
using Tet = std::array<Eigen::Vector3d, 4>;

double volume_of(const Tet& tet) {
  const Eigen::Vector3d a = tet[1] - tet[0], b = tet[2] - tet[0], c = tet[3] - tet[0];
  return std::abs(a.dot(b.cross(c))) / 6;
}

/// The integrals of 1, xi and xi xi^T over tetrahedra.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(const Tet& tet) {
    const double V = volume_of(tet);
    const Eigen::Vector3d sum = tet[0] + tet[1] + tet[2] + tet[3];
    Eigen::Matrix3d squares = sum * sum.transpose();
    for (const Eigen::Vector3d& p : tet) squares += p * p.transpose();
    volume += V;
    first += V / 4 * sum;
    second += V / 20 * squares;
  }
  Eigen::Vector3d centroid() const { return first / volume; }
  Eigen::Matrix3d covariance() const {
    return second / volume - centroid() * centroid().transpose();
  }
};

const Tet& reference_tet() {
  static const Tet tet = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0),
                          Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)};
  return tet;
}

Moments whole() {
  Moments moments;
  moments.add(reference_tet());
  return moments;
}

/// The part of a tetrahedron where a linear function is positive, in tetrahedra.
/// @param value  of it at the corners.
void clip(const Tet& tet, const double value[4], std::vector<Tet>& parts) {
  // corners in front, then those behind
  int order[4] = {0, 1, 2, 3};
  const auto front =
      int(std::stable_partition(order, order + 4, [&](int c) { return value[c] > 0; }) - order);
  const auto corner = [&](int k) { return tet[size_t(order[k])]; };
  const auto between = [&](int k, int l) -> Eigen::Vector3d {
    const double a = value[order[k]], b = value[order[l]];
    return corner(k) + a / (a - b) * (corner(l) - corner(k));
  };
  // a wedge between two triangles p and q
  const auto wedge = [&](const std::array<Eigen::Vector3d, 6>& p) {
    parts.push_back({p[0], p[1], p[2], p[3]});
    parts.push_back({p[1], p[2], p[3], p[4]});
    parts.push_back({p[2], p[3], p[4], p[5]});
  };
  if (front == 4) parts.push_back(tet);
  if (front == 1) parts.push_back({corner(0), between(0, 1), between(0, 2), between(0, 3)});
  if (front == 2)
    wedge({corner(0), between(0, 2), between(0, 3), corner(1), between(1, 2), between(1, 3)});
  if (front == 3)
    wedge({corner(0), corner(1), corner(2), between(0, 3), between(1, 3), between(2, 3)});
}

/// The eight tetrahedra of half the edges.
void halve(const Tet& t, int times, std::vector<Tet>& parts) {
  if (times == 0) return parts.push_back(t);
  const auto m = [&](size_t a, size_t b) -> Eigen::Vector3d { return (t[a] + t[b]) / 2; };
  const Eigen::Vector3d a = m(0, 1), b = m(0, 2), c = m(0, 3), d = m(1, 2), e = m(1, 3),
                        f = m(2, 3);
  for (const Tet& part :
       {Tet{t[0], a, b, c}, Tet{a, t[1], d, e}, Tet{b, d, t[2], f}, Tet{c, e, f, t[3]},
        Tet{a, f, b, c}, Tet{a, f, c, e}, Tet{a, f, e, d}, Tet{a, f, d, b}})
    halve(part, times - 1, parts);
}

class Cutter {
 public:
  Cutter(const ElementMesh& mesh, const std::vector<Border>& borders)
      : mesh_(mesh), borders_(borders), whole_(whole()), margin_(kNodeOnBorder * extent_of(mesh)) {
    // the reference tetrahedron is A times one whose second moments are those of I
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(whole_.covariance());
    A_ = solver.operatorSqrt();
    A_inverse_ = solver.operatorInverseSqrt();
  }

  /// Borders that cut an element. @return whether one holds it whole.
  bool find(int64_t element, std::vector<int32_t>& cutting) const {
    cutting.clear();
    for (size_t b = 0; b < borders_.size(); ++b) {
      double least = 1e300, most = -1e300;
      for (int c = 0; c < 4; ++c) {
        const double d = distance(borders_[b], corner(element, c));
        least = std::min(least, d), most = std::max(most, d);
      }
      if (most <= margin_) return true;
      if (least < -margin_ || (!borders_[b].is_plane && holds_some(element, borders_[b], least)))
        cutting.push_back(int32_t(b));
    }
    return false;
  }

  /// The free part of an element that borders cut.
  Moments free_part(int64_t element, const std::vector<int32_t>& cutting) const {
    // planes clip it
    std::vector<Tet> parts = {reference_tet()}, next;
    bool planes_alone = true;
    for (const int32_t b : cutting) {
      const Border& border = borders_[size_t(b)];
      planes_alone &= border.is_plane;
      if (!border.is_plane) continue;
      next.clear();
      for (const Tet& part : parts) {
        double value[4];
        for (size_t c = 0; c < 4; ++c) value[c] = distance(border, place(element, part[c]));
        clip(part, value, next);
      }
      parts.swap(next);
    }
    Moments moments;
    if (planes_alone) {
      for (const Tet& part : parts) moments.add(part);
      return moments;
    }
    // of others small tetrahedra count
    next.clear();
    for (const Tet& part : parts) halve(part, kHalvings, next);
    for (const Tet& part : next)
      if (is_free(element, part, cutting)) moments.add(part);
    return moments;
  }

  double share(const Moments& moments) const { return moments.volume / whole_.volume; }

  /// The map xi = b + B xi_0 of the reference tetrahedron to one with the moments of a part, B row by
  /// row, then b. Of all such maps it is the one that turns least.
  void write_part(const Moments& moments, double* part) const {
    const Eigen::Matrix3d seen = A_inverse_ * moments.covariance() * A_inverse_;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(seen);
    const Eigen::Matrix3d root = solver.eigenvectors() *
                                 solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                                 solver.eigenvectors().transpose();
    const Eigen::Matrix3d B = A_ * root * A_inverse_;
    const Eigen::Vector3d b = moments.centroid() - B * whole_.centroid();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) part[3 * i + j] = B(i, j);
      part[9 + i] = b(i);
    }
  }

 private:
  static double extent_of(const ElementMesh& mesh) {
    Box box;
    for (int64_t n = 0; n < mesh.rest.rows(); ++n)
      box.add({mesh.rest(n, 0), mesh.rest(n, 1), mesh.rest(n, 2)});
    return std::max({box.extent(0), box.extent(1), box.extent(2)});
  }

  Vec3 corner(int64_t element, int c) const {
    const double* X = mesh_.rest.row(mesh_.elements(element, c));
    return {X[0], X[1], X[2]};
  }

  Vec3 place(int64_t element, const Eigen::Vector3d& xi) const {
    Vec3 x = scaled(corner(element, 0), 1 - xi.sum());
    for (int c = 1; c < 4; ++c) x = plus(x, scaled(corner(element, c), xi[c - 1]));
    return x;
  }

  bool is_free(int64_t element, const Tet& part, const std::vector<int32_t>& cutting) const {
    const Vec3 x = place(element, (part[0] + part[1] + part[2] + part[3]) / 4);
    return std::ranges::all_of(cutting,
                               [&](int32_t b) { return distance(borders_[size_t(b)], x) > 0; });
  }

  /// Whether a ball or box has some of the small tetrahedra.
  bool holds_some(int64_t element, const Border& border, double least) const {
    double edge = 0;
    for (int c = 1; c < 4; ++c)
      edge = std::max(edge, norm(minus(corner(element, c), corner(element, 0))));
    if (least > 2 * edge) return false;
    std::vector<Tet> parts;
    halve(reference_tet(), kHalvings, parts);
    return std::ranges::any_of(parts, [&](const Tet& part) {
      return distance(border, place(element, (part[0] + part[1] + part[2] + part[3]) / 4)) <= 0;
    });
  }

  const ElementMesh& mesh_;
  const std::vector<Border>& borders_;
  Moments whole_;
  double margin_;
  Eigen::Matrix3d A_, A_inverse_;
};

}  // namespace

CutTets cut_tets(const ElementMesh& mesh, const std::vector<Border>& borders) {
  if (borders.empty()) return {mesh, {}, {}};
  const Cutter cutter(mesh, borders);
  const int64_t elements = mesh.elements.rows();
  Array<double> share(elements), part(elements, 12);
  std::vector<std::vector<int32_t>> cutting(static_cast<size_t>(elements));
  for_each(elements, [&](int64_t e) {
    for (int d = 0; d < 3; ++d) part(e, 4 * d) = 1;
    if (cutter.find(e, cutting[size_t(e)])) return;
    share(e) = 1;
    if (cutting[size_t(e)].empty()) return;
    const Moments moments = cutter.free_part(e, cutting[size_t(e)]);
    share(e) = cutter.share(moments);
    if (share(e) > kNothing) cutter.write_part(moments, part.row(e));
  });
  // the elements with a free part
  std::vector<int64_t> kept;
  CutTets result;
  for (int64_t e = 0; e < elements; ++e) {
    if (share(e) <= kNothing) continue;
    for (const int32_t b : cutting[size_t(e)]) result.cut.push_back({int32_t(kept.size()), b});
    kept.push_back(e);
  }
  result.mesh = some_elements(mesh, kept);
  result.mesh.fill = Array<double>(int64_t(kept.size()));
  result.mesh.part = Array<double>(int64_t(kept.size()), 12);
  for (size_t k = 0; k < kept.size(); ++k) {
    result.mesh.fill(int64_t(k)) = share(kept[k]) * fill_of(mesh, kept[k]);
    std::copy_n(part.row(kept[k]), 12, result.mesh.part.row(int64_t(k)));
  }
  result.number = std::move(kept);
  return result;
}

bool cuts(const ElementMesh& mesh, const Border& border) {
  const std::vector<Border> borders = {border};
  const Cutter cutter(mesh, borders);
  std::vector<int32_t> cutting;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const bool held = cutter.find(e, cutting);
    if (!held && !cutting.empty()) return true;
  }
  return false;
}

}  // namespace elastogen::fem

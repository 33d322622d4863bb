// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fem_pieces.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/fem/mesh_pieces.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

/// The moments of a piece about another point, to which its centre of mass has the distance `arm`.
Mat3<double> moments_about(const PieceMotion& piece, double mass, const Vec3& arm) {
  Mat3<double> I = piece.inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      I(i, j) += mass * ((i == j ? dot(arm, arm) : 0) - arm[size_t(i)] * arm[size_t(j)]);
  return I;
}

/// The inverse, or 0 where the mass lies on a line.
Mat3<double> inverse_moments(const Mat3<double>& I) {
  const Mat3<double> result = inverse(I);
  const bool exists =
      std::all_of(result.m, result.m + 9, [](double entry) { return std::isfinite(entry); });
  return exists ? result : Mat3<double>{};
}

}  // namespace

FemPieces::FemPieces(const FemScene& scene, const MassMatrix& mass)
    : scene_(scene), matrix_(mass), piece_(mesh_pieces(scene.mesh)), node_mass_(piece_.rows()) {
  find_masses();
  find_holds();
  find_pins();
  // the trace of the moments is twice sum r . M r
  const Array<double> rest(piece_.rows(), 3);
  for (const PieceMotion& piece : motions(rest, rest)) {
    const Mat3<double>& I = piece.inertia;
    size_.push_back(2 * std::sqrt((I(0, 0) + I(1, 1) + I(2, 2)) / (2 * mass_[size_.size()])));
  }
}

/// Masses of nodes and pieces, and the first node of each piece.
void FemPieces::find_masses() {
  // M 1 by one component of the nodal vectors
  const int64_t nodes = piece_.rows();
  Array<double> ones(nodes, 3);
  ones.fill(1);
  const Array<double> M1 = multiplied(ones);
  std::vector<int64_t> unused;
  for (int64_t n = 0; n < nodes; ++n) {
    if (piece_(n) < 0) {
      unused.push_back(n);
      continue;
    }
    node_mass_(n) = M1(n, 0);
    if (of(n) == count()) first_.push_back(n), mass_.push_back(0);
    mass_[of(n)] += node_mass_(n);
  }
  // nodes whose elements are held whole go with a piece that borders hold
  for (const int64_t n : unused) {
    ELASTOGEN_CHECK(!scene_.dependent.empty() && scene_.fixed(n, 0), "node ", n,
                    " belongs to no element");
    piece_(n) = piece_(scene_.dependent.node(0));
  }
}

/// Which pieces are held, and along which axes alone.
void FemPieces::find_holds() {
  loose_.assign(count(), 1);
  stops_.resize(count());
  for (int64_t i = 0; i < scene_.dependent.count(); ++i) loose_[of(scene_.dependent.node(i))] = 0;
  for (int64_t n = 0; n < piece_.rows() && !scene_.fixed.empty(); ++n) {
    const uint8_t* fixed = scene_.fixed.row(n);
    const int held = (fixed[0] != 0) + (fixed[1] != 0) + (fixed[2] != 0);
    if (held == 3 || (held > 0 && scene_.motion)) loose_[of(n)] = 0;
    for (size_t d = 0; d < 3 && held < 3; ++d)
      if (fixed[d]) stops_[of(n)][d] = true;
  }
}

/// Where pieces are held, if nothing moves them there.
void FemPieces::find_pins() {
  pins_.resize(count());
  pinned_.resize(count());
  if (scene_.motion || scene_.dependent_motion) return;
  std::vector<double> share(count());
  const auto add = [&](size_t p, int32_t n, double weight) {
    pins_[p] = plus(pins_[p], scaled(row_of(scene_.mesh.rest, n), weight));
    share[p] += weight;
  };
  for (int64_t n = 0; n < piece_.rows() && !scene_.fixed.empty(); ++n) {
    const uint8_t* fixed = scene_.fixed.row(n);
    if (fixed[0] && fixed[1] && fixed[2] && node_mass_(n) > 0) add(of(n), int32_t(n), 1);
  }
  // the points of borders that dependent nodes follow from
  const DependentNodes& dependent = scene_.dependent;
  for (int64_t i = 0; i < dependent.count(); ++i) {
    const size_t p = of(dependent.node(i));
    add(p, dependent.node(i), 1);
    for (int64_t m = 0; m < dependent.parents(i).size(); ++m)
      add(p, dependent.parents(i).data[m], -dependent.weights(i).data[m]);
  }
  for (size_t p = 0; p < count(); ++p) {
    pinned_[p] = share[p] > 0;
    if (pinned_[p]) pins_[p] = scaled(pins_[p], 1 / share[p]);
  }
}

Array<double> FemPieces::multiplied(In<double> y) const {
  Array<double> My(y.rows, 3);
  matrix_.multiply(y.data, My.data());
  return My;
}

std::vector<PieceMotion> FemPieces::motions(In<double> u, In<double> v) const {
  // places from a node of each piece, so that no digits are lost far away
  const Array<double>& rest = scene_.mesh.rest;
  Array<double> r(u.rows, 3);
  for (int64_t n = 0; n < u.rows; ++n)
    for (int d = 0; d < 3; ++d) {
      const int64_t first = first_[of(n)];
      r(n, d) = rest(n, d) - rest(first, d) + (u(n, d) - u(first, d));
    }
  const Array<double> Mr = multiplied(r), Mv = multiplied(v);
  // centres and their velocities
  std::vector<PieceMotion> pieces(count());
  for (int64_t n = 0; n < u.rows; ++n) {
    PieceMotion& piece = pieces[of(n)];
    piece.centre = plus(piece.centre, scaled(row_of(Mr, n), 1 / mass_[of(n)]));
    piece.velocity = plus(piece.velocity, scaled(row_of(Mv, n), 1 / mass_[of(n)]));
  }
  // what is about them
  for (int64_t n = 0; n < u.rows; ++n) {
    PieceMotion& piece = pieces[of(n)];
    const Vec3 arm = minus(row_of(r, n), piece.centre),
               M_arm = minus(row_of(Mr, n), scaled(piece.centre, node_mass_(n)));
    const Vec3 Mv_about = minus(row_of(Mv, n), scaled(piece.velocity, node_mass_(n)));
    piece.spin = plus(piece.spin, cross(arm, Mv_about));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double other =
            (arm[size_t(i)] * M_arm[size_t(j)] + arm[size_t(j)] * M_arm[size_t(i)]);
        piece.inertia(i, j) += (i == j ? dot(arm, M_arm) : 0) - other / 2;
      }
  }
  for (size_t p = 0; p < count(); ++p)
    pieces[p].centre = plus(pieces[p].centre, plus(row_of(rest, first_[p]), row_of(u, first_[p])));
  return pieces;
}

std::vector<double> FemPieces::rms(In<double> y) const {
  const Array<double> My = multiplied(y);
  std::vector<double> square(count());
  for (int64_t n = 0; n < y.rows; ++n) square[of(n)] += dot(row_of(y, n), row_of(My, n));
  for (size_t p = 0; p < count(); ++p) square[p] = std::sqrt(std::max(square[p], 0.0) / mass_[p]);
  return square;
}

double FemPieces::product(In<double> y, In<double> z) const {
  const Array<double> Mz = multiplied(z);
  return elastogen::dot(y.data, Mz.data(), y.size());
}

/// What makes of a piece's angular momentum its angular velocity, about the axes that it may turn about.
Mat3<double> FemPieces::per_inertia(size_t piece, const Mat3<double>& inertia) const {
  const std::array<bool, 3>& stops = stops_[piece];
  const auto count = std::count(stops.begin(), stops.end(), true);
  if (count == 0) return inverse_moments(inertia);
  Mat3<double> result = {};
  const auto axis = int(std::find(stops.begin(), stops.end(), true) - stops.begin());
  if (count == 1 && inertia(axis, axis) > 0) result(axis, axis) = 1 / inertia(axis, axis);
  return result;
}

RigidMotion FemPieces::rigid_motion(size_t piece, const PieceMotion& motion) const {
  RigidMotion result{motion.centre, motion.velocity, motion.spin,
                     per_inertia(piece, motion.inertia)};
  for (size_t d = 0; d < 3; ++d)
    if (stops_[piece][d]) result.velocity[d] = 0;
  // what is left of the spin is about the axis that it may turn about
  for (int d = 0; d < 3; ++d)
    if (!(result.per_inertia(d, d) > 0)) result.spin[size_t(d)] = 0;
  return result;
}

Vec3 FemPieces::turn_about_pins(size_t piece, const PieceMotion& motion) const {
  const Vec3 arm = minus(motion.centre, pins_[piece]);
  const Vec3 spin = plus(motion.spin, scaled(cross(arm, motion.velocity), mass_[piece]));
  return times(per_inertia(piece, moments_about(motion, mass_[piece], arm)), spin);
}

Array<double> FemPieces::rigid_part(In<double> u, const std::vector<PieceMotion>& motion) const {
  std::vector<Vec3> V(count()), w(count());
  for (size_t p = 0; p < count(); ++p) {
    const RigidMotion rigid = rigid_motion(p, motion[p]);
    V[p] = rigid.velocity;
    w[p] = times(rigid.per_inertia, rigid.spin);
  }
  Array<double> field(u.rows, 3);
  for (int64_t n = 0; n < u.rows; ++n) {
    const size_t p = of(n);
    if (!is_loose(p)) continue;
    const Vec3 arm = minus(plus(row_of(scene_.mesh.rest, n), row_of(u, n)), motion[p].centre);
    const Vec3 value = plus(V[p], cross(w[p], arm));
    std::copy(value.begin(), value.end(), field.row(n));
  }
  return field;
}

}  // namespace elastogen::fem

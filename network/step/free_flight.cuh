// SPDX-License-Identifier: Apache-2.0
// The free pieces of a scene, which nothing holds, on the device: sums over the nodes of each piece
// in a fixed order, and its motion as a whole (predictor.hpp, free_flight.hpp).

#pragma once

#include "core/cuda/groups.cuh"
#include "core/polar.hpp"
#include "core/scene.hpp"

namespace elastogen::cuda {

/// The tables of the pieces, as kernels read them.
struct PiecesView {
  const int32_t* first;
  const double *rest_centre, *per_mass;
};

/// Centre of mass and mean rotation of a piece.
struct PieceFrame {
  double centre[3];
  Mat3<double> rotation;
};

class DevicePieces {
 public:
  /// The scene must be complete.
  explicit DevicePieces(const Scene& scene);

  int64_t count() const { return groups_.count(); }
  PiecesView view() const { return {groups_.view().first, rest_centre_.data(), per_mass_.data()}; }

  /// Calls body(piece, node) for every node of a free piece.
  template <class Body>
  void for_each(const Body& body) const {
    groups_.for_each(body);
  }

  /// As FreeFlight::match_means; aim(k) is the aim of the number k = 3 node + component.
  template <class Aim>
  void match_means(const double* mass, double* values, const Aim& aim) {
    const PiecesView g = view();
    double* shift = shift_.data();
    groups_.sums(
        excess_,
        [=] __device__(int64_t, int64_t n, Sums<3> & sum) {
          for (int i = 0; i < 3; ++i)
            sum.value[i] += mass[n] * (values[3 * n + i] - aim(3 * n + i));
        },
        [=] __device__(int64_t p, const Sums<3>& sum) {
          for (int i = 0; i < 3; ++i) shift[3 * p + i] = sum.value[i] * g.per_mass[p];
        });
    for_each([=] __device__(int64_t p, int64_t n) {
      for (int i = 0; i < 3; ++i) values[3 * n + i] -= shift[3 * p + i];
    });
  }

  /// Sets u of the free pieces at the start of a step; other nodes keep theirs.
  /// @param x, x_before, predictor  of all nodes, on the device; predictor is xhat - rest.
  void start(const double* rest, const double* mass, const double* x, const double* x_before,
             const double* predictor, double* u);

  /// Finds the frames of the pieces, (pieces), with number k = 3 node + component at position(k).
  template <class Position>
  void find_frames(const double* rest, const double* mass, const Position& position,
                   PieceFrame* frames);

 private:
  DevicePieces(const Scene& scene, const std::vector<std::vector<int32_t>>& pieces);

  DeviceGroups groups_;              // nodes of the pieces
  DeviceArray<double> rest_centre_;  // of mass [m], (pieces, 3)
  DeviceArray<double> per_mass_;     // [1/kg]
  DeviceArray<double> shift_;        // of match_means, (pieces, 3)
  DeviceArray<Sums<3>> excess_;      // of the chunks
  DeviceArray<Sums<12>> moments_;    // of the chunks
  DeviceArray<PieceFrame> frames_;   // now, before and next, (3, pieces)
};

}  // namespace elastogen::cuda

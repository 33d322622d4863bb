// SPDX-License-Identifier: Apache-2.0
// The wind on the nodes of a grid at the end of a step or stage, where it depends on the positions and
// velocities that the step leads to. A solve takes loads as given, so it is repeated until what it was
// given is the wind where it ended. With F the wind there, f what was given, m the mass of a node and D
// what the drag there gains with speed, the next solve is given f + g,
//
//     g = (F - f) / (1 + k D/m),
//
// Newton's step for a node that nothing else holds; from the second solve on it is Anderson's
// combination of the last ones, which finds what the body's stiffness adds.

#pragma once

#include "core/loads.hpp"

namespace elastogen {

class WindLoad {
 public:
  /// All must outlive it.
  /// @param mass  of each node [kg], (nodes, 1).
  WindLoad(const Wind& wind, const VoxelGrid& grid, const Array<double>& mass);

  /// Begins a step or stage that ends at a time [s], where a force f on a node gives it the velocity
  /// k f/m. Its first solve is given the wind of the last one.
  void begin(double time, double k);
  /// Lets the first solve begin with the wind at the start of the step, (nodes, 3).
  void start(const double* x, const double* v);
  /// Takes the wind at the end of a solve, at positions [m] and velocities [m/s], (nodes, 3).
  void take(const double* x, const double* v);
  /// After take(): gives the next solve its load.
  void relax();

  /// What was given or taken last [N], (nodes, 3).
  const Array<double>& force() const { return force_; }

 private:
  struct PointForce {
    Vec3 force = {};
    double drag = 0;  // force over relative speed [kg/s]
  };
  /// What a solve was given, and the step from there to the next.
  struct Trial {
    std::vector<double> given, step;
  };
  struct PartOfPoint {
    int32_t point;
    double weight;
  };

  void list_points();
  PointForce at(int64_t point, const Vec3& air, const double* x, const double* v) const;
  std::vector<double> combined(const std::vector<double>& step) const;

  const Wind& wind_;
  const VoxelGrid& grid_;
  const Array<double>& mass_;
  double time_ = 0, k_ = 0;
  std::vector<int64_t> begin_;      // of each node in parts_, (nodes + 1)
  std::vector<PartOfPoint> parts_;  // of the points that act on each node, in their order
  std::vector<PointForce> points_;
  std::vector<double> drag_, given_;  // (nodes); (3 nodes)
  Array<double> force_;               // (nodes, 3)
  std::vector<Trial> trials_;         // the last solves of the step, the last one at the end
};

}  // namespace elastogen

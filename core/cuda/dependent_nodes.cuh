// SPDX-License-Identifier: Apache-2.0
// Dependent nodes (core/dependent_nodes.hpp) on the device. Each number is a sum of one thread in
// the order of the host, so that results have its bits. Launches do not wait for the device;
// without dependent nodes there are none.

#pragma once

#include "core/base.hpp"
#include "core/cuda/array.cuh"
#include "core/dependent_nodes.hpp"

namespace elastogen::cuda {

class DeviceDependentNodes {
 public:
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceDependentNodes(const DependentNodes& of)
      : filled_(of.filled()), folded_(of.folded()) {}

  /// The dependent nodes, with their parent nodes as sources.
  WeightedSums sums() const { return filled_.view(); }
  /// The parent nodes, with their dependent nodes as sources.
  WeightedSums parents() const { return folded_.view(); }

  /// As DependentNodes::fill; (nodes, 3), on the device.
  template <class T>
  void fill(T* values) const;
  /// As fill(), and an offset to each dependent node, (count).
  void fill(double* values, const Vec3* offsets) const;
  /// As DependentNodes::fold.
  template <class T>
  void fold(T* gradient) const;

 private:
  struct Lists {
    explicit Lists(const DependentNodes::Sums& of)
        : nodes(of.nodes), begin(of.begin), sources(of.sources), weights(of.weights) {}
    WeightedSums view() const {
      return {nodes.data(), begin.data(), sources.data(), weights.data(), nodes.size()};
    }
    DeviceArray<int32_t> nodes, begin, sources;
    DeviceArray<double> weights;
  };

  Lists filled_, folded_;
};

}  // namespace elastogen::cuda

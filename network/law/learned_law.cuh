// SPDX-License-Identifier: Apache-2.0
// Materials on the device: a law, and the correction that a net adds to it, from a table or from
// the net itself. The net itself takes three passes: a pass over the voxels stores the log
// stretches at which nets are needed, a kernel evaluates the nets there, in float64 as on the host,
// and the pass that needs the corrections reads them.

#pragma once

#include "network/potential/brick_rows.cuh"
#include "network/potential/local_model.hpp"

namespace elastogen::cuda {

/// A net that is evaluated itself, without a table.
struct NetView {
  const float* weights = nullptr;  ///< of NeuralMtl, W2 column-major; null: there is none
  MtlTerms terms;
  double mu = 0, lambda = 0;  ///< of the net's law with E = 1
};

/// A material, as kernels read it.
struct DeviceMaterial {
  LawParameters<double> law;
  MtlTableView table = {};  ///< without coefficients: the law alone, or the net
  NetView net = {};
  double viscous_time = 0;  ///< of its damping (core/viscous.hpp) [s]
};

/// Response of a material to stretches; `added` is the correction by a net.
template <class T, bool kHessian, class Added>
struct Respond {
  LawParameters<T> law;
  Added added;

  __device__ bool has_net() const { return added.exists(); }
  __device__ LogResponse<T> difference(const T e[3]) const {
    return added.template at<kHessian>(e);
  }
  __device__ Response<T> operator()(const T sigma[3], T& outside) const {
    outside = 0;
    if (!has_net()) return elastic_response<kHessian>(law, sigma);
    const auto at = [&](const T e[3]) { return difference(e); };
    return corrected_response<kHessian>(law, sigma, at, outside);
  }
};

template <bool kHessian, class T, class Added>
__device__ inline Respond<T, kHessian, Added> response_of(const LawParameters<T>& law,
                                                          const Added& added) {
  return {law, added};
}

/// For scenes without nets: their kernels contain no code for them.
struct NoNets {
  struct Added {
    __device__ static constexpr bool exists() { return false; }
    template <bool kHessian, class T>
    __device__ static LogResponse<T> at(const T*) {
      return {};
    }
  };

  __device__ Added operator()(const VoxelRow&, int64_t, int) const { return {}; }
};

/// Corrections by tables of nets.
struct NetTables {
  struct Added {
    MtlTableView table;
    __device__ bool exists() const { return table.coefficients != nullptr; }
    template <bool kHessian, class T>
    __device__ LogResponse<T> at(const T e[3]) const {
      return table.evaluate<kHessian>(e);
    }
  };

  const DeviceMaterial* materials;
  __device__ Added operator()(const VoxelRow& row, int64_t, int) const {
    return {materials[row.material].table};
  }
};

inline constexpr int kNetFields = 10;  ///< psi, w, ww

/// Corrections that evaluate_nets has found, [row][10][lane], or by tables of nets.
struct NetResults {
  struct Added {
    MtlTableView table;
    const double* result;  ///< of the voxel's row and lane; null: by the table
    __device__ bool exists() const { return result || table.coefficients; }
    template <bool kHessian, class T>
    __device__ LogResponse<T> at(const T e[3]) const {
      if (!result) return table.evaluate<kHessian>(e);
      LogResponse<T> r{};
      r.psi = T(result[0]);
      for (int i = 0; i < 3; ++i) r.w[i] = T(result[(1 + i) * kLanes]);
      if constexpr (kHessian)
        for (int c = 0; c < 6; ++c) r.ww[c] = T(result[(4 + c) * kLanes]);
      return r;
    }
  };

  const DeviceMaterial* materials;
  const double* results;
  __device__ Added operator()(const VoxelRow& row, int64_t r, int lane) const {
    const DeviceMaterial& m = materials[row.material];
    return {m.table, m.net.weights ? results + r * kNetFields * kLanes + lane : nullptr};
  }
};

/// Stores the log stretches at which a net is needed, [row][3][lane]; the correction is 0.
struct NetQuestions {
  struct Added {
    double* logs;  ///< of the voxel's row and lane; null: no net
    __device__ bool exists() const { return logs != nullptr; }
    template <bool kHessian, class T>
    __device__ LogResponse<T> at(const T e[3]) const {
      for (int i = 0; i < 3; ++i) logs[i * kLanes] = double(e[i]);
      return {};
    }
  };

  const DeviceMaterial* materials;
  double* logs;
  __device__ Added operator()(const VoxelRow& row, int64_t r, int lane) const {
    return {materials[row.material].net.weights ? logs + r * 3 * kLanes + lane : nullptr};
  }
};

/// Evaluates the nets at the log stretches, with second derivatives if kHessian, in the rows of
/// materials whose net is evaluated itself.
template <bool kHessian>
void evaluate_nets(const DeviceRows& rows, const DeviceMaterial* materials, const double* logs,
                   double* results);

}  // namespace elastogen::cuda

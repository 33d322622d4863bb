// SPDX-License-Identifier: Apache-2.0
// Materials on the device: a law, and what a net adds to it, by its table or by the net itself. The
// latter takes three passes: one over the voxels leaves the log stretches at which they ask, a
// kernel evaluates the nets at all of them, in float64 as on the host, and the pass that needs what
// they add finds it there.

#pragma once

#include "network/potential/brick_rows.cuh"
#include "network/potential/local_model.hpp"

namespace elastogen::cuda {

/// A net that is evaluated itself.
struct NetView {
  const float* weights = nullptr;  ///< of NeuralMtl, W2 column-major; null: there is none
  MtlTerms terms;
  double mu = 0, lambda = 0;  ///< of its law with E = 1
};

/// A material, as kernels take it.
struct DeviceMaterial {
  LawParameters<double> law;
  MtlTableView table = {};  ///< without coefficients: the law itself, or the net
  NetView net = {};
};

/// Response of a material to stretches; `added` is what a net adds to its law.
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

/// Scenes without nets, whose kernels have no code for them.
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

/// What nets add by their tables.
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

/// What nets add where they have been evaluated, [row][10][lane]; by tables where there are some.
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

/// Leaves the log stretches at which a net is asked, [row][3][lane], and adds nothing.
struct NetQuestions {
  struct Added {
    double* logs;  ///< of the voxel's row and lane; null: no net to ask
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

/// What nets add at the log stretches, with second derivatives or without; in the rows whose
/// material is one that is evaluated itself.
template <bool kHessian>
void evaluate_nets(const DeviceRows& rows, const DeviceMaterial* materials, const double* logs,
                   double* results);

}  // namespace elastogen::cuda

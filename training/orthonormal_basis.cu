// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/launch.cuh"
#include "training/orthonormal_basis.hpp"
#include "training/orthonormal_basis_impl.hpp"

namespace elastogen::cuda {
namespace {

constexpr int kThreads = 160;

/// The threads of a block as a team.
struct Block {
  int lane = int(threadIdx.x), lanes = int(blockDim.x);
  __device__ Block() {}
  __device__ void sync() const { __syncthreads(); }
};

/// One block for each matrix, which fits in shared memory.
__global__ void bases_kernel(int n, const float* A, float* Q) {
  extern __shared__ float shared[];
  float *const work = shared, *const basis = shared + n * n, *const tau = basis + n * n;
  const int64_t begin = int64_t(blockIdx.x) * n * n;
  const Block block;
  for (int k = block.lane; k < n * n; k += block.lanes) work[k] = A[begin + k];
  block.sync();
  householder::orthonormal_basis(block, n, work, tau, basis);
  for (int k = block.lane; k < n * n; k += block.lanes) Q[begin + k] = basis[k];
}

}  // namespace

void orthonormal_bases(int64_t count, int n, const float* A, float* Q) {
  if (count == 0) return;
  const int bytes = (2 * n * n + n) * int(sizeof(float));
  check(cudaFuncSetAttribute(bases_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, bytes));
  bases_kernel<<<unsigned(count), kThreads, size_t(bytes)>>>(n, A, Q);
  check(cudaGetLastError());
}

}  // namespace elastogen::cuda

// SPDX-License-Identifier: Apache-2.0
// The V-cycle of the device against that of the CPU. Nothing is here in builds without CUDA;
// skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/device_multigrid.cuh"

#include "network/device.hpp"
#include "tests/network/multigrid_scenes.hpp"

#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace elastogen::test {
namespace {

void check(cudaError_t error) {
  if (error != cudaSuccess) throw std::runtime_error(cudaGetErrorString(error));
}

/// Numbers on the device.
template <class T>
class Numbers {
 public:
  explicit Numbers(const std::vector<T>& host) : size_(host.size()) {
    check(cudaMalloc(reinterpret_cast<void**>(&data_), size_ * sizeof(T)));
    check(cudaMemcpy(data_, host.data(), size_ * sizeof(T), cudaMemcpyHostToDevice));
  }
  ~Numbers() { cudaFree(data_); }
  Numbers(const Numbers&) = delete;
  T* data() { return data_; }
  std::vector<T> host() const {
    check(cudaDeviceSynchronize());
    std::vector<T> values(size_);
    check(cudaMemcpy(values.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost));
    return values;
  }

 private:
  T* data_ = nullptr;
  size_t size_;
};

class MultigridOnCard : public testing::Test {
 protected:
  void SetUp() override {
    if (!cuda::has_device()) GTEST_SKIP() << "there is no CUDA device here";
  }
};

/// A cycle of the device like one of the host, and more with the same bits.
template <class T>
void expect_cycle_of_host(const Scene& scene, Multigrid<T>& host, double bound, int more = 1) {
  cuda::DeviceMultigrid<T> device(host);
  const std::vector<double> random = random_field(scene, 1, 9);
  const std::vector<T> r(random.begin(), random.end());
  std::vector<T> expected(r.size());
  host.apply(r.data(), expected.data());
  // what stood in z must not matter
  Numbers<T> from(r), z(std::vector<T>(r.size(), T(7))), again(std::vector<T>(r.size(), T(-3)));
  device.apply(from.data(), z.data());
  EXPECT_LT(relative_difference(z.host(), expected), bound);
  for (int k = 0; k < more; ++k) device.apply(from.data(), again.data());
  EXPECT_EQ(z.host(), again.host());
}

template <class T>
void check_cycles(double bound) {
  for (const NamedScene& named : multigrid_scenes()) {
    Multigrid<T> host(named.scene, 1);
    for (const bool stiffened : {false, true}) {
      SCOPED_TRACE(named.name + (stiffened ? ", stiffened" : ""));
      if (stiffened) host.set_nodal_stiffness(some_stiffness(named.scene));
      expect_cycle_of_host(named.scene, host, bound);
    }
  }
}

TEST_F(MultigridOnCard, CyclesAreThoseOfTheHostInDouble) {
  check_cycles<double>(1e-12);
}

TEST_F(MultigridOnCard, CyclesAreThoseOfTheHostInFloat) {
  check_cycles<float>(2e-5);
}

TEST_F(MultigridOnCard, CycleOfManyLevels) {
  // levels of their own launches above those of the cluster
  const Scene scene = clamped_beam(90, 70, 61, 0.02, solid(1e5, 0.45));
  Multigrid<double> host(scene, 1);
  EXPECT_GE(host.level_count(), 5);
  expect_cycle_of_host(scene, host, 1e-12);
}

TEST_F(MultigridOnCard, AThousandCyclesLeaveNothingBehind) {
  // what slots without a free node kept would grow from cycle to cycle
  const Scene scene = clamped_beam(90, 70, 61, 0.02, solid(1e5, 0.45));
  Multigrid<float> host(scene, 1);
  expect_cycle_of_host(scene, host, 2e-5, 1000);
}

TEST_F(MultigridOnCard, CycleIsSymmetric) {
  const Scene scene = ragged_of_two_materials(50, 26, 37);
  const Multigrid<double> host(scene, 1);
  cuda::DeviceMultigrid<double> device(host);
  const std::vector<double> x = random_field(scene, 1, 1), y = random_field(scene, 1, 2);
  Numbers<double> from_x(x), from_y(y), Bx(x), By(y);
  device.apply(from_x.data(), Bx.data());
  device.apply(from_y.data(), By.data());
  const std::vector<double> bx = Bx.host(), by = By.host();
  EXPECT_NEAR(dot(x, by), dot(y, bx), 1e-12 * norm(x) * norm(by));
  EXPECT_GT(dot(x, bx), 0);
}

}  // namespace
}  // namespace elastogen::test

#endif

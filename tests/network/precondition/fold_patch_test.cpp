// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/fold_patch.hpp"

#include "core/pcg.hpp"
#include "network/precondition/preconditioner.hpp"
#include "tests/network/precondition/folded_bar.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

TEST(VoxelStiffness, MakesTheHessianOfTheBody) {
  Folded of(2.2);
  const std::vector<double> random = random_field(of.scene, 1, 3);
  const std::vector<float> p(random.begin(), random.end());
  std::vector<float> product(p.size());
  of.potential.hessian_product(p.data(), product.data());
  std::vector<double> sum(p.size()), K(24 * 24);
  const VoxelStiffness stiffness(of.potential, of.u.data());
  for (int64_t v = 0; v < of.scene.grid.voxel_count(); ++v) {
    stiffness.matrix(v, K.data());
    const int32_t* corners = of.scene.grid.corners.row(v);
    for (int a = 0; a < 24; ++a)
      for (int b = 0; b < 24; ++b)
        sum[size_t(3 * corners[a / 3] + a % 3)] +=
            K[size_t(24 * a + b)] * double(p[size_t(3 * corners[b / 3] + b % 3)]);
  }
  double most = 0;
  for (const float value : product) most = std::max(most, double(std::abs(value)));
  for (int64_t k = 0; k < of.size(); ++k)
    if (!of.scene.pinned(k / 3)) {
      EXPECT_NEAR(product[size_t(k)],
                  sum[size_t(k)] + of.potential.inertia(k / 3) * double(p[size_t(k)]), 1e-5 * most);
    }
}

TEST(FoldPatch, IsEmptyWhereNothingFolds) {
  Folded of(0.3);
  FoldPatch patch;
  patch.update(of.potential, of.u.data());
  EXPECT_TRUE(patch.empty());
}

TEST(FoldPatch, KeepsTheFirstMatrixSymmetricAndPositive) {
  Folded of(2.6);
  Preconditioner<double> first(of.potential, {});
  first.update_folds(of.u.data());
  ASSERT_TRUE(first.has_folds());
  std::vector<double> r = random_field(of.scene, 1, 4), s = random_field(of.scene, 1, 5),
                      Br(r.size()), Bs(r.size());
  for (int64_t k = 0; k < of.size(); ++k)
    if (of.scene.pinned(k / 3)) r[size_t(k)] = s[size_t(k)] = 0;
  first.apply(r.data(), Br.data());
  first.apply(s.data(), Bs.data());
  EXPECT_NEAR(dot(r, Bs), dot(s, Br), 1e-5 * norm(r) * norm(Bs));
  EXPECT_GT(dot(r, Br), 0);
  // to the bit, and as before without folds
  std::vector<double> again(r.size()), plain(r.size()), cleared(r.size());
  first.apply(r.data(), again.data());
  EXPECT_EQ(again, Br);
  first.clear_folds();
  first.apply(r.data(), cleared.data());
  Preconditioner<double>(of.potential, {}).apply(r.data(), plain.data());
  EXPECT_EQ(cleared, plain);
}

TEST(FoldPatch, TakesFewerIterationsInAFold) {
  for (const double angle : {2.6, 2.8, 3.0}) {
    Folded of(angle);
    Preconditioner<float> first(of.potential, {});
    const std::vector<double> random = random_field(of.scene, 1, 6);
    std::vector<float> b(random.begin(), random.end()), x(b.size());
    for (int64_t k = 0; k < of.size(); ++k)
      if (of.scene.pinned(k / 3)) b[size_t(k)] = 0;
    PcgWork<float> work(of.size());
    const auto iterations = [&] {
      return pcg(
                 b.data(), x.data(), of.size(), 1e-4, 500, work,
                 [&](const float* p, float* Ap) { of.potential.hessian_product(p, Ap); },
                 [&](const float* q, float* z) { first.apply(q, z); })
          .iterations;
    };
    const int plain = iterations();
    first.update_folds(of.u.data());
    const int with = iterations();
    printf("fold of %.1f: %d iterations, %d without the patch\n", angle, with, plain);
    EXPECT_LT(with, 0.7 * plain);
  }
}

}  // namespace
}  // namespace elastogen::test

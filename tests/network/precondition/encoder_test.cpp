// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/encoder.hpp"

#include "network/precondition/smooth_modes.hpp"
#include "tests/network/precondition/multigrid_scenes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr int kCoarseSize = 3 * Encoder<double>::kModes;

struct Rest {
  explicit Rest(const Scene& s) : scene(s), potential(s) {
    potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  }
  std::vector<double> product(const std::vector<double>& p) {
    std::vector<double> Ap(p.size());
    potential.rest_hessian_product(p.data(), Ap.data());
    return Ap;
  }
  const Scene& scene;
  IncrementalPotential potential;
};

/// |B^T (r - A z)| / |B^T r| with z = B A_r^-1 B^T r; the quadratic must not rise either.
void expect_projection(const Scene& scene, unsigned seed) {
  Rest rest(scene);
  Encoder<double> encoder(rest.potential);
  ASSERT_GE(encoder.piece_count(), 1);
  std::vector<double> r = random_field(scene, 1, seed), z(r.size());
  for (size_t k = 0; k < r.size(); ++k)
    if (!scene.pinned(int64_t(k / 3))) r[k] += scene.grid.rest(int64_t(k / 3), int(k % 3)) + 1;
  encoder.add(r.data(), z.data());
  const std::vector<double> Az = rest.product(z);
  EXPECT_LT(dot(z, Az) / 2 - dot(z, r), 0);
  std::vector<double> left = r;
  for (size_t k = 0; k < r.size(); ++k) left[k] -= Az[k];
  std::vector<double> before(size_t(encoder.piece_count()) * kCoarseSize), after(before);
  encoder.encode(r.data(), before.data());
  encoder.encode(left.data(), after.data());
  EXPECT_LT(norm(after), 1e-6 * norm(before));
}

TEST(Encoder, SolvesTheQuadraticExactlyInItsModes) {
  for (const double poisson : {0.0, 0.3, 0.49}) {
    expect_projection(clamped_beam(16, 6, 5, 0.05, solid(1e6, poisson)), 51);
    Scene ball = scene_on(ball_grid(4, 1), solid(1e7, poisson));
    finish_scene(ball);
    expect_projection(ball, 52);
  }
}

TEST(Encoder, SolvesTheQuadraticOfMaterialsAndWeightsThatDifferFromVoxelToVoxel) {
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
    Scene scene = ragged_of_two_materials(12, 10, 9);
    scene.hourglass = hourglass;
    finish_scene(scene);
    expect_projection(scene, 55);
  }
}

/// A_r of a body of one piece: products with the decoded modes, encoded.
Eigen::MatrixXd reduced_operator(Rest& rest, const Encoder<double>& encoder) {
  Eigen::MatrixXd A(kCoarseSize, kCoarseSize);
  std::vector<double> mode(3 * size_t(rest.scene.grid.node_count()));
  for (int k = 0; k < kCoarseSize; ++k) {
    const Eigen::VectorXd y = Eigen::VectorXd::Unit(kCoarseSize, k);
    encoder.decode(y.data(), mode.data());
    encoder.encode(rest.product(mode).data(), A.col(k).data());
    std::fill(mode.begin(), mode.end(), 0);
  }
  return A;
}

/// The entries that couple a component with itself.
Eigen::MatrixXd within_components(const Eigen::MatrixXd& A) {
  return Eigen::MatrixXd::NullaryExpr(A.rows(), A.cols(), [&](Eigen::Index a, Eigen::Index b) {
    return a % 3 == b % 3 ? A(a, b) : 0;
  });
}

TEST(Encoder, CorrectionIsTheInverseLessWhatMultigridKnows) {
  for (const double poisson : {0.0, 0.3, 0.49}) {
    const Scene scene = clamped_beam(16, 6, 5, 0.05, solid(1e6, poisson));
    Rest rest(scene);
    Encoder<double> encoder(rest.potential);
    const Eigen::MatrixXd A = reduced_operator(rest, encoder);
    const std::vector<double> r = random_field(scene, 1, 56);
    Eigen::VectorXd y(kCoarseSize);
    encoder.encode(r.data(), y.data());
    const Eigen::VectorXd solution = A.llt().solve(y) - 0.8 * within_components(A).llt().solve(y);
    std::vector<double> z(r.size()), expected(r.size());
    encoder.decode(solution.data(), expected.data());
    encoder.add_correction(r.data(), z.data());
    EXPECT_LT(relative_difference(z, expected), 1e-6) << poisson;
  }
}

TEST(Encoder, SoftnessIsTheLargestEigenvalueOfWhatMultigridKnowsOverTheOperator) {
  for (const double C : {0.1, 3.0, 100.0})
    for (const double poisson : {0.0, 0.45}) {
      const double h = 0.05;
      const Scene scene =
          clamped_beam(16, 6, 5, h, solid(young_of_courant(C, h, 1.0 / 60), poisson));
      Rest rest(scene);
      const Encoder<double> encoder(rest.potential);
      const Eigen::MatrixXd A = reduced_operator(rest, encoder);
      const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
          within_components(A), A, Eigen::EigenvaluesOnly);
      const double largest = solver.eigenvalues().maxCoeff();
      printf("C %g, nu %g: softness %.4f\n", C, poisson, largest);
      EXPECT_LE(encoder.softness(), largest * (1 + 1e-6));
      EXPECT_GE(encoder.softness(), 0.95 * largest);
      if (C == 0.1) {
        EXPECT_LT(largest, 1.1);
      }
      if (C == 100) {
        EXPECT_GT(largest, 5);
      }
    }
}

TEST(Encoder, IsThereWhereItIsSoftByASampleToo) {
  // twice the voxels of a sample, so that every second block is looked at first
  Scene scene = scene_on(ball_grid(33, 1), solid(young_of_courant(60, 1, 1.0 / 60), 0.3));
  finish_scene(scene);
  ASSERT_GT(scene.grid.voxel_count(), 2 << 16);
  Rest rest(scene);
  const Encoder<float> encoder(rest.potential);
  const double softness = encoder.softness();
  printf("%d voxels, softness %.3f\n", int(scene.grid.voxel_count()), softness);
  ASSERT_GT(softness, 5);
  EXPECT_FALSE(Encoder<float>::if_soft(rest.potential, 1.1 * softness));
  const auto made = Encoder<float>::if_soft(rest.potential, 0.9 * softness);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->pieces()[0].rest, encoder.pieces()[0].rest);
  EXPECT_EQ(made->pieces()[0].correction, encoder.pieces()[0].correction);
}

TEST(Encoder, IsTheSameForOneAndTwoThreads) {
  const Scene scene = ragged_of_two_materials(12, 10, 9);
  Rest rest(scene);
  std::vector<Encoder<float>::Piece> built[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    built[threads - 1] = Encoder<float>(rest.potential).pieces();
  }
  ASSERT_EQ(built[0].size(), 1u);
  EXPECT_EQ(built[0][0].nodes, built[1][0].nodes);
  EXPECT_EQ(built[0][0].modes, built[1][0].modes);
  EXPECT_EQ(built[0][0].rest, built[1][0].rest);
  EXPECT_EQ(built[0][0].inverse, built[1][0].inverse);
}

TEST(Encoder, PinDistanceIsThatToTheNearestPinOfThePiece) {
  // two blocks, pins in bulk and single ones in the first, none in the second
  std::vector<std::array<int32_t, 3>> list;
  for (int z = 0; z < 10; ++z)
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 12; ++x)
        if (x != 7 || y == 3) list.push_back({x, y, z}), list.push_back({x + 20, y, z});
  Array<int32_t> coords(int64_t(list.size()), 3);
  for (size_t v = 0; v < list.size(); ++v)
    std::copy(list[v].begin(), list[v].end(), coords.row(int64_t(v)));
  Scene scene = scene_on(make_grid(coords, 0.1, {}), solid(1e6, 0.3));
  ASSERT_EQ(scene.grid.pieces, 2);
  const int64_t nodes = scene.grid.node_count();
  std::vector<int32_t> all;
  for (int64_t n = 0; n < nodes; ++n) {
    const int32_t* at = scene.grid.node_coord.row(n);
    scene.pinned(n) = at[0] <= 4 && at[1] <= 5 && at[2] >= 3;
    scene.pinned(n) |= at[0] < 20 && (at[0] * 31 + at[1] * 17 + at[2] * 5) % 97 == 0;
    all.push_back(int32_t(n));
  }
  const Zeroed<double> distance = pin_distance(scene, PinTrees(scene), all);
  for (int64_t n = 0; n < nodes; ++n) {
    double nearest = 1e300;
    for (int64_t m = 0; m < nodes; ++m) {
      if (!scene.pinned(m) || scene.grid.piece(m) != scene.grid.piece(n)) continue;
      double square = 0;
      for (int d = 0; d < 3; ++d)
        square += std::pow(scene.grid.node_coord(n, d) - scene.grid.node_coord(m, d), 2);
      nearest = std::min(nearest, 0.1 * std::sqrt(square));
    }
    ASSERT_EQ(distance[size_t(n)], nearest);
  }
}

TEST(Encoder, SurvivesModesThatCoincide) {
  // a needle one voxel thick: cosines across it repeat each other on its two layers of nodes
  const Scene needle = clamped_beam(40, 1, 1, 0.05, solid(1e6, 0.3));
  Rest rest(needle);
  Encoder<double> encoder(rest.potential);
  std::vector<double> r = random_field(needle, 1, 53), z(r.size());
  encoder.add(r.data(), z.data());
  for (const double value : z) ASSERT_TRUE(std::isfinite(value));
  EXPECT_LE(dot(z, rest.product(z)) / 2 - dot(z, r), 0);
  EXPECT_GT(dot(z, r), 0);
  expect_projection(needle, 53);
}

TEST(Encoder, ModesVanishAtPins) {
  const Scene scene = clamped_beam(16, 6, 5, 0.05, solid(1e6, 0.3));
  Rest rest(scene);
  Encoder<double> encoder(rest.potential);
  std::vector<double> y(kCoarseSize, 1.0), z(3 * size_t(scene.grid.node_count()));
  for (int k = 0; k < kCoarseSize; ++k) y[size_t(k)] = 1 + 0.1 * k;
  encoder.decode(y.data(), z.data());
  double largest = 0;
  for (size_t k = 0; k < z.size(); ++k) {
    if (scene.pinned(int64_t(k / 3))) {
      ASSERT_EQ(z[k], 0);
    }
    largest = std::max(largest, std::abs(z[k]));
  }
  EXPECT_GT(largest, 1);
}

TEST(Encoder, FactorIsTheDistanceToTheNearestPinOverItselfPlusAnEighth) {
  // the constant cosine of the x component is the factor alone
  const double h = 0.05, L = 16 * h;
  const Scene scene = clamped_beam(16, 6, 5, h, solid(1e6, 0.3));
  Rest rest(scene);
  Encoder<double> encoder(rest.potential);
  std::vector<double> y(kCoarseSize), z(3 * size_t(scene.grid.node_count()));
  y[0] = 1;
  encoder.decode(y.data(), z.data());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const double d = scene.grid.rest(n, 0);
    ASSERT_NEAR(z[size_t(3 * n)], d / (d + L / 8), 1e-13);
    ASSERT_EQ(z[size_t(3 * n + 1)], 0);
  }
}

TEST(Encoder, DecodingIsTheTransposeOfEncoding) {
  const Scene scene = clamped_beam(16, 6, 5, 0.05, solid(1e6, 0.3));
  Rest rest(scene);
  Encoder<double> encoder(rest.potential);
  const std::vector<double> r = random_field(scene, 1, 54);
  std::vector<double> y(kCoarseSize), Btr(kCoarseSize), By(r.size());
  for (int k = 0; k < kCoarseSize; ++k) y[size_t(k)] = std::sin(k + 1);
  encoder.encode(r.data(), Btr.data());
  encoder.decode(y.data(), By.data());
  EXPECT_NEAR(dot(r, By), dot(y, Btr), 1e-12 * norm(r) * norm(By));
}

TEST(Encoder, PiecesDoNotKnowOfEachOther) {
  // a box of 5 x 5 x 5 alone, and the same box beside a larger one
  const auto box = [](std::vector<std::array<int32_t, 3>>& list, int x0, int size) {
    for (int z = 0; z < size; ++z)
      for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) list.push_back({x0 + x, y, z});
  };
  const auto scene_of = [](const std::vector<std::array<int32_t, 3>>& list) {
    Array<int32_t> coords(int64_t(list.size()), 3);
    for (size_t v = 0; v < list.size(); ++v)
      std::copy(list[v].begin(), list[v].end(), coords.row(int64_t(v)));
    Scene scene = scene_on(make_grid(coords, 0.1, {}), solid(1e6, 0.3));
    finish_scene(scene);
    return scene;
  };
  std::vector<std::array<int32_t, 3>> one, two;
  box(one, 0, 5);
  box(two, 0, 5);
  box(two, 9, 6);
  const Scene alone = scene_of(one), both = scene_of(two);
  Rest rest_alone(alone), rest_both(both);
  Encoder<double> encoder_alone(rest_alone.potential), encoder_both(rest_both.potential);
  EXPECT_EQ(encoder_alone.piece_count(), 1);
  EXPECT_EQ(encoder_both.piece_count(), 2);

  const auto load = [](const Scene& scene, int64_t n, int i) {
    const double* X = scene.grid.rest.row(n);
    return X[0] > 0.7 ? 0.0 : std::sin(10 * X[0] + 7 * X[1] - 5 * X[2] + i);
  };
  const auto solution = [&](const Scene& scene, Encoder<double>& encoder) {
    std::vector<double> r(3 * size_t(scene.grid.node_count())), z(r.size());
    for (size_t k = 0; k < r.size(); ++k) r[k] = load(scene, int64_t(k / 3), int(k % 3));
    encoder.add(r.data(), z.data());
    return z;
  };
  const std::vector<double> a = solution(alone, encoder_alone), b = solution(both, encoder_both);
  double largest = 0;
  for (int64_t n = 0; n < both.grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i) {
      const double value = b[size_t(3 * n + i)];
      if (both.grid.rest(n, 0) > 0.7) {
        ASSERT_EQ(value, 0);
        continue;
      }
      for (int64_t m = 0; m < alone.grid.node_count(); ++m) {
        bool same = true;
        for (int d = 0; d < 3; ++d)
          same &= alone.grid.node_coord(m, d) == both.grid.node_coord(n, d);
        if (same) largest = std::max(largest, std::abs(value - a[size_t(3 * m + i)]));
      }
    }
  EXPECT_LT(largest, 1e-9 * norm(a));
}

}  // namespace
}  // namespace elastogen::test

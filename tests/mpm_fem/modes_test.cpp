// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/modes.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using fem::Mass;
using fem::Modes;
using fem::vibration_modes;

TEST(Modes, AreThoseOfTheDenseMatrices) {
  for (const Element element : {Element::kVoxel, Element::kHexBbar, Element::kTet10}) {
    FemScene scene = box_of(element, 3, 2, 1, 0.1, solid(Law::kNeoHookean, 1e6, 0.3));
    clamp(scene, 0, 0);
    const ElasticBody body(scene.mesh, scene.materials);
    const Array<double> mass = body.lumped_mass();
    const Eigen::MatrixXd K = hessian(body, Array<double>(mass.rows(), 3));
    std::vector<Eigen::Index> kept;
    for (int64_t k = 0; k < K.rows(); ++k)
      if (!scene.fixed.data()[k]) kept.push_back(k);
    Eigen::VectorXd m(kept.size());
    for (size_t k = 0; k < kept.size(); ++k) m(Eigen::Index(k)) = mass(kept[k] / 3);
    const Eigen::MatrixXd scaled = m.cwiseSqrt().cwiseInverse().asDiagonal() * K(kept, kept) *
                                   m.cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::VectorXd expected =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
            .eigenvalues();
    const Modes modes = vibration_modes(scene, 8);
    for (int k = 0; k < 8; ++k)
      EXPECT_NEAR(modes.omega_squared[size_t(k)], expected(k), 1e-10 * expected(k));
    for (int64_t k = 0; k < K.rows(); ++k)
      ASSERT_TRUE(!scene.fixed.data()[k] || modes.shape(0, int(k)) == 0);
  }
}

TEST(Modes, OfAFreeBodyHaveSixRigidMotions) {
  for (const Mass mass : {Mass::kLumped, Mass::kConsistent}) {
    FemScene scene = box_of(Element::kTet10, 4, 2, 1, 0.1, solid(Law::kNeoHookean, 1e6, 0.3));
    scene.mass_kind = mass;
    const Modes modes = vibration_modes(scene, 9);
    for (int k = 0; k < 6; ++k)
      EXPECT_LT(std::abs(modes.omega_squared[size_t(k)]), 1e-9 * modes.omega_squared[6]);
    EXPECT_GT(modes.frequency[6], 1);
  }
}

TEST(Modes, OfTheStandardBeamAreEulersAndTimoshenkos) {
  // E1: 1 m x 0.1 m x 0.1 m, E = 1e8, rho = 1000: 5.1083, 32.013 Hz by Euler and Bernoulli; the
  // second is lower by shear and rotation, about 3 %
  struct Row {
    Element element;
    int across;
    double poisson;
  };
  const Row rows[] = {{Element::kTet10, 2, 0},
                      {Element::kTet10, 2, 0.3},
                      {Element::kHexBbar, 8, 0},
                      {Element::kVoxel, 4, 0}};
  for (const Row& row : rows) {
    FemScene scene = box_of(row.element, 10 * row.across, row.across, row.across, 0.1 / row.across,
                            solid(Law::kNeoHookean, 1e8, row.poisson));
    clamp(scene, 0, 0);
    for (const Mass mass : {Mass::kLumped, Mass::kConsistent}) {
      scene.mass_kind = mass;
      const Modes modes = vibration_modes(scene, 4);
      printf("%-8s n = %d, nu = %.1f, %s mass: f1 = %.4f, %.4f, f2 = %.3f Hz\n",
             std::string(element_name(row.element)).c_str(), row.across, row.poisson,
             mass == Mass::kLumped ? "lumped" : "consistent", modes.frequency[0],
             modes.frequency[1], modes.frequency[2]);
      EXPECT_NEAR(modes.frequency[0], 5.1083, 0.01 * 5.1083);
      EXPECT_NEAR(modes.frequency[1], modes.frequency[0], 0.01 * 5.1083);  // the other direction
      EXPECT_NEAR(modes.frequency[2], 0.97 * 32.013, 0.02 * 32.013);
    }
  }
}

TEST(Modes, RejectsWhatItsDocumentationForbids) {
  const FemScene scene = box_of(Element::kHex, 1, 1, 1, 1, solid());
  EXPECT_THROW(vibration_modes(scene, 0), Error);
  EXPECT_THROW(vibration_modes(scene, 24), Error);
  EXPECT_THROW(vibration_modes(scene, 1, Array<double>(3, 3)), Error);
}

}  // namespace
}  // namespace elastogen::test

// SPDX-License-Identifier: Apache-2.0
// Steps of bodies that yield against closed forms: the bar, confined compression, shear and
// bending, all so slow that inertia does not count.

#include "core/error.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace elastogen {
namespace {

using fem::FemState;
using fem::ImplicitFem;
using fem::PlasticBody;
using test::Element;
using test::FemScene;

constexpr double kYoung = 1e7, kPoisson = 0.3, kYield = 2e4, kHardening = 1e6;

Material metal(double young = kYoung) {
  return test::solid(Law::kHencky, young, kPoisson, 1000);
}

/// A slow scene of metal with roller planes through the origin.
FemScene slow(fem::ElementMesh mesh, double hardening) {
  FemScene scene = test::scene_of(std::move(mesh), metal());
  scene.yields = {MetalYield{.stress = kYield, .hardening = hardening}};
  scene.dt = 1e4;
  return scene;
}

void roll(FemScene& scene) {
  for (int axis = 0; axis < 3; ++axis) test::fix(scene, axis, 0, axis);
}

/// Sum of a component of the forces on the nodes of a plane [N].
double reaction(const FemScene& scene, const FemState& state, int axis, double place,
                int component) {
  PlasticBody body(scene.mesh, {{scene.materials[0], scene.yields[0]}});
  body.set_history(state.plastic);
  Array<double> f(state.u.rows(), 3);
  body.add_gradient(state.u, f);
  double sum = 0;
  for (const int64_t n : test::plane(scene.mesh, axis, place)) sum += f(n, component);
  return sum;
}

double largest_memory(const FemState& state) {
  const Array<double>& memory = state.plastic.memory;
  return *std::max_element(memory.data(), memory.data() + memory.size());
}

/// Kirchhoff's stress of a bar of length 2 and section 1 whose end is at displacement(time),
/// step by step.
struct Bar {
  std::vector<double> strain, stress;
  double plastic_work = 0, elastic = 0;
};
Bar pull(Element element, double hardening, const std::vector<double>& strains) {
  FemScene scene = slow(test::block(element, 2, 1, 1, 1), hardening);
  roll(scene);
  test::fix(scene, 0, 2, 0);
  const std::vector<int64_t> end = test::plane(scene.mesh, 0, 2);
  scene.motion = [&](double time, Out<double> u) {
    const auto step = size_t(std::lround(time / 1e4));
    for (const int64_t n : end) u(n, 0) = 2 * std::expm1(step == 0 ? 0 : strains[step - 1]);
  };
  ImplicitFem solver(scene);
  FemState state = rest_state(scene);
  Bar bar;
  for (const double strain : strains) {
    const fem::FemStepReport report = solver.step(state);
    EXPECT_LT(report.residual, 1e-6);
    bar.strain.push_back(strain);
    bar.stress.push_back(reaction(scene, state, 0, 2, 0) * std::exp(strain));
    bar.plastic_work = report.energy.plastic, bar.elastic = report.energy.elastic;
  }
  return bar;
}

class Elements : public testing::TestWithParam<Element> {};

TEST_P(Elements, ABarYieldsHardensAndUnloadsAsItsTheorySays) {
  const double yield = kYield / kYoung, slope = kYoung * kHardening / (kYoung + kHardening);
  const Bar bar = pull(GetParam(), kHardening, {0.5 * yield, 0.999 * yield, 0.01, 0.02, 0.019});
  EXPECT_NEAR(bar.stress[0], kYoung * bar.strain[0], 1e-6 * kYield);
  EXPECT_NEAR(bar.stress[1], 0.999 * kYield, 1e-6 * kYield);
  for (const size_t k : {2u, 3u})
    EXPECT_NEAR(bar.stress[k], kYield + slope * (bar.strain[k] - yield), 1e-6 * kYield);
  EXPECT_NEAR(bar.stress[3] - bar.stress[4], kYoung * 0.001, 1e-6 * kYield);
  // sigma_Y eps_p + H eps_p^2/2 over the volume of 2
  const double flow = 0.02 - bar.stress[3] / kYoung;
  EXPECT_NEAR(bar.plastic_work, 2 * (kYield * flow + kHardening * flow * flow / 2),
              1e-6 * bar.plastic_work);
  EXPECT_NEAR(bar.elastic, 2 * bar.stress[4] * bar.stress[4] / (2 * kYoung), 1e-5 * bar.elastic);
}

INSTANTIATE_TEST_SUITE_P(PlasticFem, Elements,
                         testing::Values(Element::kHex, Element::kHexBbar, Element::kTet4,
                                         Element::kTet10, Element::kTet10Bbar));

TEST(PlasticFem, ConfinedCompressionYieldsWhereTheTheorySays) {
  const double stress = kYield * (1 - kPoisson) / (1 - 2 * kPoisson);
  const Material m = metal();
  const double strain = stress / (m.lambda() + 2 * m.mu());
  for (const double share : {0.999, 1.001}) {
    FemScene scene = slow(test::block(Element::kHexBbar, 2, 1, 1, 1), 0);
    scene.fixed.fill(1);
    scene.motion = [&](double, Out<double> u) {
      for (int64_t n = 0; n < u.rows; ++n)
        u(n, 0) = scene.mesh.rest(n, 0) * std::expm1(-share * strain);
    };
    ImplicitFem solver(scene);
    FemState state = rest_state(scene);
    solver.step(state);
    EXPECT_EQ(largest_memory(state) > 0, share > 1);
    EXPECT_NEAR(reaction(scene, state, 0, 2, 0) * std::exp(-share * strain), -share * stress,
                2e-3 * stress);
  }
}

TEST(PlasticFem, ShearFlowsAtTheYieldStressOverRootThree) {
  FemScene scene = slow(test::block(Element::kHexBbar, 1, 1, 1, 1), 0);
  scene.fixed.fill(1);
  scene.motion = [&](double, Out<double> u) {
    for (int64_t n = 0; n < u.rows; ++n) u(n, 0) = 0.01 * scene.mesh.rest(n, 1);
  };
  ImplicitFem solver(scene);
  FemState state = rest_state(scene);
  solver.step(state);
  EXPECT_NEAR(reaction(scene, state, 1, 1, 0), kYield / std::sqrt(3.0), 1e-4 * kYield);
}

/// A bar of section 1 and length 2 under a force at its end.
FemScene loaded_bar(double hardening, double force) {
  FemScene scene = slow(test::block(Element::kHexBbar, 2, 1, 1, 1), hardening);
  roll(scene);
  scene.traction = Array<double>(scene.mesh.rest.rows(), 3);
  for (const int64_t n : test::plane(scene.mesh, 0, 2)) scene.traction(n, 0) = force / 4;
  return scene;
}

TEST(PlasticFem, StaticsOfABarUnderAForceAreThoseOfItsLine) {
  const double force = 1.2 * kYield, yield = kYield / kYoung;
  const double slope = kYoung * kHardening / (kYoung + kHardening);
  const fem::StaticResult result = solve_static(loaded_bar(kHardening, force));
  ASSERT_TRUE(result.converged);
  EXPECT_EQ(result.increments, 16);
  // sigma_Y + slope (e - e_Y) = force exp(e)
  double e = 0.1;
  for (int k = 0; k < 50; ++k)
    e -= (kYield + slope * (e - yield) - force * std::exp(e)) / (slope - force * std::exp(e));
  for (const int64_t n : test::plane(test::block(Element::kHexBbar, 2, 1, 1, 1), 0, 2))
    EXPECT_NEAR(result.u(n, 0), 2 * std::expm1(e), 1e-6 * 2 * e);
  const double flow = e - force * std::exp(e) / kYoung;
  EXPECT_NEAR(result.energy.plastic, 2 * (kYield * flow + kHardening * flow * flow / 2),
              1e-3 * result.energy.plastic);
}

TEST(PlasticFem, StaticsEndAtTheLoadThatTheBarBears) {
  const fem::StaticResult result = solve_static(loaded_bar(0, 1.25 * kYield));
  EXPECT_FALSE(result.converged);
  // force exp(sigma_Y/E) is the yield stress
  EXPECT_NEAR(result.load_factor, std::exp(-kYield / kYoung) / 1.25, 1e-3);
}

/// Moment over width of a narrow beam of height 1 that is bent to the curvature.
double moment(Element element, double curvature) {
  constexpr double kWidth = 0.125, kLength = 0.125;
  FemScene scene = slow(test::block(element, 1, 8, 1, 0.125), 0);
  for (const double place : {0.0, kLength}) test::fix(scene, 0, place, 0);
  test::fix(scene, 1, 0.5, 1);
  test::fix(scene, 2, 0, 2);
  scene.motion = [&](double, Out<double> u) {
    for (int64_t n = 0; n < u.rows; ++n)
      u(n, 0) = curvature * scene.mesh.rest(n, 0) * (scene.mesh.rest(n, 1) - 0.5);
  };
  ImplicitFem solver(scene);
  FemState state = rest_state(scene);
  EXPECT_LT(solver.step(state).residual, 1e-6);
  PlasticBody body(scene.mesh, {{scene.materials[0], scene.yields[0]}});
  body.set_history(state.plastic);
  Array<double> f(state.u.rows(), 3);
  body.add_gradient(state.u, f);
  double sum = 0;
  for (const int64_t n : test::plane(scene.mesh, 0, kLength))
    sum += f(n, 0) * (scene.mesh.rest(n, 1) - 0.5);
  return sum / kWidth;
}

TEST(PlasticFem, ABeamBearsItsPlasticMoment) {
  // 25 times the curvature of first yield: all but 1/1875 of sigma_Y b h^2/4
  const double curvature = 25 * 2 * kYield / kYoung;
  EXPECT_NEAR(moment(Element::kHexBbar, curvature), kYield / 4, 0.02 * kYield / 4);
  std::printf("plastic moment over sigma_Y b h^2/4: hex %.3f, hex-bbar %.3f\n",
              moment(Element::kHex, curvature) / (kYield / 4),
              moment(Element::kHexBbar, curvature) / (kYield / 4));
  // below yield E I kappa
  EXPECT_NEAR(moment(Element::kHexBbar, 1e-3), kYoung / 12 * 1e-3, 0.02 * kYoung / 12 * 1e-3);
}

/// A block of a solid that flies, turning and shaken.
FemScene flying(const Yield& yield) {
  FemScene scene = test::scene_of(test::block(Element::kHexBbar, 2, 2, 2, 0.1), metal(1e6));
  scene.yields = {yield};
  scene.dt = 2e-3;
  return scene;
}

FemState shaken(const FemScene& scene) {
  FemState state = rest_state(scene);
  test::Random random(1);
  std::normal_distribution<double> normal(0, 1);
  for (int64_t n = 0; n < state.v.rows(); ++n) {
    for (int i = 0; i < 3; ++i) state.v(n, i) = normal(random);
    state.v(n, 0) += 3 - 10 * scene.mesh.rest(n, 1);
    state.v(n, 1) += 10 * scene.mesh.rest(n, 0);
  }
  return state;
}

const Yield kYields[] = {MetalYield{.stress = 2e3, .hardening = 1e4},
                         SandYield{.friction = 0.5, .cohesion = 1e-3},
                         SnowYield{.slope = 1.2, .pressure = 5e3}};

TEST(PlasticFem, FreeFlightKeepsTheMomentum) {
  for (const Yield& yield : kYields) {
    const FemScene scene = flying(yield);
    ImplicitFem solver(scene, {.tolerance = 1e-9});
    FemState state = shaken(scene);
    const Array<double>& m = solver.potential().mass().nodal();
    const auto momentum = [&](int component) {
      double sum = 0;
      for (int64_t n = 0; n < m.rows(); ++n) sum += m(n) * state.v(n, component);
      return sum;
    };
    const double start[3] = {momentum(0), momentum(1), momentum(2)};
    double plastic = 0;
    for (int k = 0; k < 10; ++k) {
      const fem::FemStepReport report = solver.step(state);
      EXPECT_TRUE(report.converged) << k << ": " << report.residual;
      EXPECT_GE(report.energy.plastic, plastic);
      plastic = report.energy.plastic;
    }
    EXPECT_GT(plastic, 0);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(momentum(i), start[i], 1e-8);
  }
}

/// The shape of a block whose flow stretched it twofold along (1, 1, 0), and Fp.
Mat3<double> stretched() {
  const double long_way = 2, across = 1 / std::sqrt(2.0);
  Mat3<double> Fp = identity<double>();
  Fp(0, 0) = Fp(1, 1) = (long_way + across) / 2;
  Fp(0, 1) = Fp(1, 0) = (long_way - across) / 2;
  Fp(2, 2) = across;
  return Fp;
}

void spin(const FemScene& scene, double rate, FemState& state) {
  Vec3 centre = {};
  const int64_t nodes = state.u.rows();
  const auto place = [&](int64_t n, int d) { return scene.mesh.rest(n, d) + state.u(n, d); };
  for (int64_t n = 0; n < nodes; ++n)
    for (int d = 0; d < 3; ++d) centre[size_t(d)] += place(n, d) / double(nodes);
  for (int64_t n = 0; n < nodes; ++n) {
    state.v(n, 0) = -rate * (place(n, 1) - centre[1]);
    state.v(n, 1) = rate * (place(n, 0) - centre[0]);
  }
}

TEST(PlasticFem, ABlockThatFlowedSpinsAsOneMadeInItsShape) {
  // below yield and far above it
  for (const double rate : {20.0, 200.0}) {
    FemScene flowed = flying(MetalYield{.stress = 2e4}), made = flowed;
    const Mat3<double> Fp = stretched();
    FemState state = rest_state(flowed);
    for (int64_t n = 0; n < state.u.rows(); ++n)
      for (int i = 0; i < 3; ++i) {
        double x = 0;
        for (int j = 0; j < 3; ++j) x += Fp(i, j) * flowed.mesh.rest(n, j);
        state.u(n, i) = x - flowed.mesh.rest(n, i);
        made.mesh.rest(n, i) = x;
      }
    state.plastic =
        PlasticBody(flowed.mesh, {{flowed.materials[0], flowed.yields[0]}}).rest_history();
    const Mat3<double> C = cofactor(Fp);  // det Fp = 1, Fp symmetric
    for (int64_t k = 0; k < state.plastic.memory.rows(); ++k)
      std::copy_n(C.m, 9, state.plastic.Fp_inverse.row(k));
    FemState other = rest_state(made);
    spin(flowed, rate, state);
    spin(made, rate, other);
    ImplicitFem solver(flowed), of_made(made);
    double plastic = 0;
    for (int k = 0; k < 30; ++k) {
      plastic = solver.step(state).energy.plastic;
      of_made.step(other);
    }
    EXPECT_EQ(plastic > 0, rate > 100) << plastic;
    double turned = 0;
    for (int64_t n = 0; n < state.u.rows(); ++n)
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(flowed.mesh.rest(n, i) + state.u(n, i), made.mesh.rest(n, i) + other.u(n, i),
                    1e-7);
        turned = std::max(turned, std::abs(other.u(n, i)));
      }
    EXPECT_GT(turned, 0.1);
  }
}

TEST(PlasticFem, HistoryIsCommittedOnceAStep) {
  for (const Yield& yield : kYields) {
    const FemScene scene = flying(yield);
    ImplicitFem solver(scene);
    FemState state = shaken(scene);
    solver.step(state);
    FemState first = state, second = state;
    solver.step(first);
    solver.step(second);
    const auto same = [](const Array<double>& a, const Array<double>& b) {
      return std::equal(a.data(), a.data() + a.size(), b.data());
    };
    EXPECT_TRUE(same(first.u, second.u) && same(first.v, second.v));
    EXPECT_TRUE(same(first.plastic.memory, second.plastic.memory));
    EXPECT_TRUE(same(first.plastic.Fp_inverse, second.plastic.Fp_inverse));
    EXPECT_EQ(first.plastic_work, second.plastic_work);
    EXPECT_FALSE(same(first.plastic.memory, state.plastic.memory));
  }
}

TEST(PlasticFem, AnElasticMaterialInTheMeshStaysElastic) {
  FemScene scene = flying(MetalYield{.stress = 2e3});
  scene.materials.push_back(metal(1e6));
  scene.yields.push_back({});
  for (int64_t e = 0; e < 4; ++e) scene.mesh.material(e) = 1;
  ImplicitFem solver(scene);
  FemState state = shaken(scene);
  const fem::FemStepReport report = solver.step(state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(state.plastic.memory.rows(), 4 * 8);
  EXPECT_GT(report.energy.plastic, 0);
  // a mesh whose elements are all elastic builds none of it
  scene.mesh.material.fill(1);
  ImplicitFem elastic(scene);
  state = shaken(scene);
  elastic.step(state);
  EXPECT_TRUE(state.plastic.memory.empty());
}

TEST(PlasticFem, SandOnTheGroundIsCertified) {
  FemScene scene = test::scene_of(test::block(Element::kHexBbar, 3, 4, 3, 0.1),
                                  test::solid(Law::kHencky, 1e6, 0.3, 1500));
  scene.yields = {SandYield{.friction = 0.5236}};
  scene.gravity = {0, -9.81, 0};
  scene.dt = 5e-3;
  test::clamp(scene, 1, 0);
  ImplicitFem solver(scene, {.tolerance = 1e-3});
  FemState state = rest_state(scene);
  double plastic = 0;
  for (int k = 0; k < 20; ++k) {
    const fem::FemStepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << k << ": " << report.residual;
    EXPECT_GE(report.energy.plastic, plastic);
    plastic = report.energy.plastic;
  }
  EXPECT_GT(plastic, 0);
}

TEST(PlasticFem, RejectsWhatItsDocumentationForbids) {
  FemScene scene = flying(MetalYield{});
  scene.yields.push_back({});
  EXPECT_THROW(ImplicitFem{scene}, Error);
}

}  // namespace
}  // namespace elastogen

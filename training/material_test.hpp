// SPDX-License-Identifier: Apache-2.0
// A material from a test: the law, Young's modulus and shape parameter whose nominal stress is
// nearest to the measured one. Energies are linear in E, so with p the stress of the law at E = 1
// and P the measured stress
//
//     E = p.P / p.p,     error = |E p - P| / |P|,
//
// and the shape parameter is the minimum of that error (docs/materials.md, a material from a test).

#pragma once

#include "training/load_path.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// A measured point.
struct TestPoint {
  LoadPath path = LoadPath::kUniaxial;
  double stretch = 1;  ///< of the first axis
  double stress = 0;   ///< nominal, along it [Pa]
  int line = 0;        ///< line in its file
};

/// Reads points from a text. Its first line names the columns `mode` (missing: uniaxial), `stretch`
/// or `strain` = stretch - 1, and `stress` [Pa] or "stress [kPa]" with any unit of pressure. #
/// starts a comment. At least two points must not be at rest, and not all stresses may be 0.
/// @param source  name for messages. @throws Error (asset) naming line and column.
std::vector<TestPoint> read_material_test(const std::string& text, const std::string& source);

/// The law to fit; with `family` its shape parameter is fitted too.
struct TestLaw {
  Law law;
  bool family = false;
};

/// A law that law_from_name reads, or the bare name of a family, "ogden".
/// @throws Error as law_from_name.
TestLaw test_law(const std::string& name);

/// All laws of law_names.
std::vector<TestLaw> test_laws();

/// The best fit of a law.
struct TestFit {
  Law law;                     ///< with its shape parameter
  double young = 0;            ///< E [Pa]
  double error = 0;            ///< root mean square over that of the stresses
  std::vector<double> stress;  ///< stress of the law at the points, (points) [Pa]
  size_t worst = 0;            ///< point with the largest difference
  double worst_error = 0;      ///< difference there, over the root mean square of the stresses
  bool at_end = false;         ///< the shape parameter is at the end of its range
  /// A point at which the free sides have no equilibrium. The law then cannot describe the test,
  /// and error is infinite.
  std::optional<size_t> impossible;
};

/// Fits one law: E in closed form; a shape parameter on a grid over its range, then by golden
/// section around the best point of the grid, up to 1e-10 of the range.
/// @param points  from read_material_test. @param poisson  in [0, 0.499].
/// @throws Error (usage) on another Poisson ratio or fewer than two points; (asset) if E would not
///         be positive, because the stresses have the sign of pressures.
TestFit fit_test(const TestLaw& law, double poisson, const std::vector<TestPoint>& points);

/// The fits of several laws, least error first; equal errors in the given order.
std::vector<TestFit> fit_tests(const std::vector<TestLaw>& laws, double poisson,
                               const std::vector<TestPoint>& points);

/// Number of points outside the box in which nets are fitted (declared_box), by a law.
int64_t points_outside(const Law& law, double poisson, const std::vector<TestPoint>& points);

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// A material from a test: the law, its Young's modulus and its shape parameter whose nominal stress
// is nearest to the measured one. Energies are linear in E, so with p the stress of the law at
// E = 1 and P the measured one
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
  int line = 0;        ///< of its file
};

/// Points of a text whose first line names the columns `mode` (without it: uniaxial), `stretch` or
/// `strain` = stretch - 1, and `stress` [Pa] or "stress [kPa]" with any unit of pressure; # starts
/// a comment. At least two points are not at rest, and not all stresses are 0.
/// @param source  name for messages. @throws Error (asset) naming line and column.
std::vector<TestPoint> read_material_test(const std::string& text, const std::string& source);

/// What is fitted: a law, or with `family` one whose shape parameter is found.
struct TestLaw {
  Law law;
  bool family = false;
};

/// A law as law_from_name takes it, or the bare name of a family, "ogden".
/// @throws Error as law_from_name.
TestLaw test_law(const std::string& name);

/// All laws of law_names.
std::vector<TestLaw> test_laws();

/// The best of a law.
struct TestFit {
  Law law;                     ///< with its shape parameter
  double young = 0;            ///< E [Pa]
  double error = 0;            ///< root mean square over that of the stresses
  std::vector<double> stress;  ///< of the law at the points, (points) [Pa]
  size_t worst = 0;            ///< point of the largest difference
  double worst_error = 0;      ///< there, over the root mean square of the stresses
  bool at_end = false;         ///< the shape parameter is at the end of its range
  /// Point at which the free sides have no equilibrium; the law cannot stand for the test then, and
  /// error is infinite.
  std::optional<size_t> impossible;
};

/// Fits one law: E in closed form, a shape parameter on a grid over its range and then by golden
/// section around the best of the grid, down to 1e-10 of the range.
/// @param points  as read_material_test gives them. @param poisson  in [0, 0.499].
/// @throws Error (usage) on another Poisson ratio or fewer than two points; (asset) where E would
///         not be positive, because stresses have the sign of pressures.
TestFit fit_test(const TestLaw& law, double poisson, const std::vector<TestPoint>& points);

/// The fits of several laws, least error first; of equals the first.
std::vector<TestFit> fit_tests(const std::vector<TestLaw>& laws, double poisson,
                               const std::vector<TestPoint>& points);

/// Number of points that leave the box in which nets are fitted (declared_box) by a law.
int64_t points_outside(const Law& law, double poisson, const std::vector<TestPoint>& points);

}  // namespace elastogen

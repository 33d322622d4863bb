// SPDX-License-Identifier: Apache-2.0
// Results of bench/generation.cpp and the tables of them.

#pragma once

#include "diffusion/material_family.hpp"
#include "diffusion/start_fit.hpp"

#include <functional>
#include <string>
#include <vector>

namespace elastogen::bench {

inline constexpr int kIterations[] = {0, 1, 3, 10, 30, 80};
inline constexpr size_t kStages = std::size(kIterations);

/// Results of a material from one start.
struct Course {
  double start_seconds = 0;    ///< time to make the start
  std::vector<StartFit> fits;  ///< after kIterations
};

/// A start and the course of each material from there.
struct Method {
  std::string name;
  std::vector<Course> courses;
};

struct Results {
  std::vector<FitMaterial> materials;
  std::vector<Method> methods;
  std::vector<FitReport> decoded;  ///< of each material's best net after the codec; or empty
  int64_t strains = 0;             ///< strains of a report
  uint64_t seed = 0;
  int components = 0;  ///< components of the codec
};

/// Prints the tables as Markdown: all materials, then each group of laws and of Poisson ratios.
void print_tables(const Results& results);

/// The numbers of the tables, and more, as JSON.
std::string json_of(const Results& results);

}  // namespace elastogen::bench

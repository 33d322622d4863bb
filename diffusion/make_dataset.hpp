// SPDX-License-Identifier: Apache-2.0
// Fits the last layers of many materials (training/last_layer_fit.hpp) so that similar materials
// get similar layers. Each fit starts from the layer of the nearest material that has been fitted
// (in the order of Prim's minimum spanning tree over the features; the first material is the one
// nearest to Hencky's law and starts at 0). Fits that ended much higher than their neighbours, in
// another minimum, are repeated from the nearest three, and the best is kept.

#pragma once

#include "diffusion/weight_dataset.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct MakeDatasetOptions {
  int64_t count = 2000;          ///< materials 0 ... count - 1 of the family
  uint64_t seed = 1;             ///< seed of the family (material_family.hpp)
  int iterations = 80;           ///< most iterations of a fit
  int64_t strains = 2048;        ///< strains of a fit
  int64_t judged = 4000;         ///< strains of a report
  std::string checkpoint;        ///< file; empty: none
  int64_t checkpoint_fits = 64;  ///< fits between two checkpoints
  bool resume = false;           ///< resume from the checkpoint, if there is one
};

/// Fits in the order of the tree. If it was stopped, the last materials have none.
struct MadeDataset {
  WeightDataset data;  ///< in the order of the family; empty if stopped
  int64_t fits = 0;    ///< number of fits
  int64_t again = 0;   ///< number of fits repeated from neighbours
};

/// Gives the same bits whether it was resumed or not.
/// @param hidden  weights of a NeuralMTL, (17153); the last layer is ignored.
/// @throws Error (usage) on another number of weights and counts that are not positive, (asset) on
///         a checkpoint of other materials or layers, (resources) when files cannot be written.
MadeDataset make_dataset(const std::vector<float>& hidden, const MakeDatasetOptions& options,
                         const FitHooks& hooks = {});

/// An order in which each material follows a near one: numbers of materials, and for each the
/// number of the nearest earlier material, -1 for the first.
struct TreeOrder {
  std::vector<int64_t> order, parent;
};

/// @param features  (n, 15).
TreeOrder tree_order(In<double> features);

/// The rows of features nearest to x, (15), nearest first, without the row `except`.
std::vector<int64_t> nearest_rows(In<double> features, const double* x, int64_t count,
                                  int64_t except = -1);

}  // namespace elastogen

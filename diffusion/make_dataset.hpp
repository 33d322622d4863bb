// SPDX-License-Identifier: Apache-2.0
// Fits the last layers of many materials (training/last_layer_fit.hpp) so that like materials get
// like layers. Each begins from the layer of the nearest one that is there (the order is that of
// Prim's minimum spanning tree over the features, from the material nearest to Hencky's law, where
// the fit begins at 0). Those that ended much higher than their neighbours, in another minimum, are
// fitted again from the nearest three, and the best is kept.

#pragma once

#include "diffusion/weight_dataset.hpp"
#include "training/fit_neural_mtl.hpp"

namespace elastogen {

struct MakeDatasetOptions {
  int64_t count = 2000;          ///< materials 0 ... count - 1 of the family
  uint64_t seed = 1;             ///< of the family (material_family.hpp)
  int iterations = 80;           ///< of a fit, at most
  int64_t strains = 2048;        ///< of a fit
  int64_t judged = 4000;         ///< strains of a report
  std::string checkpoint;        ///< file; empty: none
  int64_t checkpoint_fits = 64;  ///< between two of them
  bool resume = false;           ///< from the checkpoint, where there is one
};

/// Fits made in the order of the tree, those of the last materials missing if it was stopped.
struct MadeDataset {
  WeightDataset data;  ///< in the order of the family; none when stopped
  int64_t fits = 0;    ///< done
  int64_t again = 0;   ///< fitted from neighbours
};

/// The same bits whether resumed or not.
/// @param hidden  weights of a NeuralMTL, (17153), the last layer ignored.
/// @throws Error (usage) on another number of weights and counts that are not positive, (asset) on
///         a checkpoint of other materials or layers, (resources) when files cannot be written.
MadeDataset make_dataset(const std::vector<float>& hidden, const MakeDatasetOptions& options,
                         const FitHooks& hooks = {});

/// Each material after one that is near: numbers in the order of the tree, and for each the number
/// of the earlier one it is nearest to, -1 for the first.
struct TreeOrder {
  std::vector<int64_t> order, parent;
};

/// @param features  (n, 15).
TreeOrder tree_order(In<double> features);

/// Rows of features nearest to x, (15), the nearest first; `except` is left out.
std::vector<int64_t> nearest_rows(In<double> features, const double* x, int64_t count,
                                  int64_t except = -1);

}  // namespace elastogen

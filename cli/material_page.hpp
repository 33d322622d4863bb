// SPDX-License-Identifier: Apache-2.0
// The page of `elastogen materials report`: a net beside its law.

#pragma once

#include "core/tensor_file.hpp"
#include "training/fit_material.hpp"

#include <string>

namespace elastogen {

/// What a page is about.
struct MaterialPage {
  FitMaterial material;
  std::string subject;  ///< as it was asked for: a law, or a preset
  TensorFile weights;   ///< with their card
  std::string place;    ///< where they are from
  std::string hash;     ///< SHA-256 of the file, hexadecimal
  std::string command;  ///< that makes the page
};

struct PageResult {
  std::string html;
  bool passes = false;  ///< the errors measured for the page, and those of the card, are in limits
};

/// Errors against limits, model card, curves along the loads of material tests with errors below,
/// and histograms of the errors on strains that neither the fit nor its card has seen. One
/// self-contained page, well-formed as XML too.
/// @throws Error (asset) where the weights are not those of a NeuralMTL.
PageResult material_page(const MaterialPage& page);

}  // namespace elastogen

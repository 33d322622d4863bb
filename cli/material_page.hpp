// SPDX-License-Identifier: Apache-2.0
// The page of `elastogen materials report`: a net beside its law.

#pragma once

#include "core/tensor_file.hpp"
#include "training/fit_material.hpp"

#include <string>

namespace elastogen {

/// Subject of a page.
struct MaterialPage {
  FitMaterial material;
  std::string subject;  ///< as typed: a law or a preset
  TensorFile weights;   ///< weights with their card
  std::string place;    ///< where the weights are from
  std::string hash;     ///< SHA-256 of the file, hexadecimal
  std::string command;  ///< that makes the page
};

struct PageResult {
  std::string html;
  bool passes = false;  ///< errors measured for the page and those of the card keep the limits
};

/// Errors against limits, model card, curves along the loads of material tests with their errors,
/// and histograms of errors on strains that neither fit nor card used. One self-contained page,
/// well-formed as XML.
/// @throws Error (asset) if the weights are not those of a NeuralMTL.
PageResult material_page(const MaterialPage& page);

}  // namespace elastogen

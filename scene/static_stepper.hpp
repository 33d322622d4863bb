// SPDX-License-Identifier: Apache-2.0
// Statics as a run of one step: from rest to the equilibrium.

#pragma once

#include "scene/stepper.hpp"

namespace elastogen {

/// A stepper with a single step that solves the equilibrium. The time after it is the load factor
/// that was reached. In its report outer counts Newton steps, inner load increments; the residual
/// is that of fem::StaticResult. Short of the full load the step is a draft.
/// @throws Error as fem_scene.
std::unique_ptr<Stepper> make_static_stepper(const Setup& setup, const RunDescription& run);

}  // namespace elastogen

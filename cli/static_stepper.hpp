// SPDX-License-Identifier: Apache-2.0
// simulate --static as a run of one step: from rest to the equilibrium.

#pragma once

#include "cli/stepper.hpp"

namespace elastogen {

/// A stepper whose one step solves the equilibrium; the time after it is the load factor that was
/// reached. In its report outer counts Newton steps and inner load increments, and the residual is
/// that of fem::StaticResult. Short of the full load the step is a draft that says how far it came.
/// @throws Error as make_stepper.
std::unique_ptr<Stepper> make_static_stepper(const Setup& setup, const AnimateOptions& options);

}  // namespace elastogen

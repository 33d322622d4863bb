// SPDX-License-Identifier: Apache-2.0
// The verbs; one source a verb.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Asset, material and pins to an animation. @return the exit code.
int animate(const AnimateOptions& options);

/// Builds a character, drops it while one hand is held, and writes demo.glb, demo.png and a table
/// of certificates. @return the exit code.
int demo(const DemoOptions& options);

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// The verbs; one source a verb.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Asset, material and pins to an animation. @return the exit code.
int animate(const AnimateOptions& options);

/// The scenes of a batch, several at a time; one that fails does not stop the others.
/// @return the exit code of the first in the order given that is not 0, or that of a signal.
/// @throws Error (usage) before anything runs where two scenes would write the same file.
int animate_batch(const BatchTask& task);

/// Builds a character, drops it while one hand is held, and writes demo.glb, demo.png and a table
/// of certificates. @return the exit code.
int demo(const DemoOptions& options);

/// An asset as a voxel file. @return the exit code.
int voxelize(const VoxelizeTask& task);

/// Prints what an asset or a scene holds, and what it costs to voxelise. @return the exit code.
int inspect(const InspectTask& task);

/// Prints all that is odd about an asset, and what is done about it. @return 0, or 3 if the asset
/// cannot be used.
int doctor(const DoctorTask& task);

/// Runs a scene on the network and on finite elements and compares them: study.json, study.csv,
/// study.html (docs/study.md), of the runs so far after a signal. @return the exit code.
int study(const StudyTask& task);

/// Measures the machine and the solvers on it (docs/user_guide.md, benchmarks).
/// @return 0, or 4 where a step missed its tolerance or a run of the baseline failed.
int bench_verb(const BenchVerb& verb);

/// Fits NeuralMTLs, makes datasets of them and trains generators of weights, most of it by the
/// library elastogen_learn. @return the exit code.
int train(const TrainVerb& task);

/// Prints presets, shows and makes nets of laws, fits laws to tests. @return the exit code.
int materials(const MaterialsTask& task);

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// The verbs, one source each.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Turns asset, material and pins into an animation. @return the exit code.
int animate(const AnimateOptions& options);

/// Runs the scenes of a batch, several at a time; one that fails does not stop the others.
/// @return the first exit code that is not 0, in the order given, or that of a signal.
/// @throws Error (usage) before anything runs if two scenes would write one file.
int animate_batch(const BatchTask& task);

/// Builds a character, drops it while one hand is held, writes demo.glb and demo.png, and prints a
/// table of certificates. @return the exit code.
int demo(const DemoOptions& options);

/// Writes an asset as a voxel file. @return the exit code.
int voxelize(const VoxelizeTask& task);

/// Prints the contents of an asset or a scene, and the cost to voxelise it. @return the exit code.
int inspect(const InspectTask& task);

/// Prints everything odd about an asset, and what is done about it. @return 0, or 3 if the asset
/// cannot be used.
int doctor(const DoctorTask& task);

/// Runs a scene on the network and on finite elements, compares them, and writes study.json,
/// study.csv and study.html (docs/study.md), after a signal from the runs so far. @return the exit
/// code.
int study(const StudyTask& task);

/// Measures the machine and the solvers on it (docs/user_guide.md, benchmarks).
/// @return 0, or 4 if a step missed its tolerance or a run of the baseline failed.
int bench_verb(const BenchVerb& verb);

/// Fits NeuralMTLs, makes datasets of them and trains generators of weights; most of it is done by
/// the library elastogen_learn. @return the exit code.
int train(const TrainVerb& task);

/// Prints presets, shows and makes nets of laws, fits laws to tests. @return the exit code.
int materials(const MaterialsTask& task);

}  // namespace elastogen

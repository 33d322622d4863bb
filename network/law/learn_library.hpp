// SPDX-License-Identifier: Apache-2.0
// The trainer is a shared library of its own, because it brings libtorch, whose loading takes about
// a second: it is opened when something is trained, by name, and has C functions only
// (diffusion/train_entry_points.hpp).

#pragma once

#include "core/error.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace elastogen {

/// Version of the tasks, LearnReply and the functions; it changes with them.
inline constexpr int kLearnVersion = 4;

/// Arguments of `elastogen train mtl` for the library; texts end with a zero.
struct TrainMtlTask {
  const char* law = "neo-hookean";  ///< of a single material, or a sum "0.3*stvk+0.7*hencky"
  double poisson = 0.45;
  const char* list = "";   ///< file of materials instead
  const char* start = "";  ///< weight file to begin from
  const char* out = "";    ///< file of a single material, folder of a list
  int64_t steps = 0, samples = 0;
  uint64_t seed = 0;
  double rate = 0;          ///< largest rate of the optimiser
  const char* device = "";  ///< "cpu" or "cuda"
  int last_layer = 0;       ///< iterations on the last layer
  int shared = 0;           ///< 1: one pair of hidden layers for a list
  int resume = 0;           ///< 1: from the checkpoint, where there is one
};

/// Arguments of `elastogen train autoencoder` and `train diffusion`
/// (diffusion/train_generator.hpp).
struct TrainGeneratorTask {
  const char* dataset = "";      ///< file of `elastogen train dataset`
  const char* autoencoder = "";  ///< file whose codes are used
  const char* out = "";
  const char* size = "compact";  ///< or "paper"
  const char* layers = "";       ///< "N,N,..." in place of the paper's
  const char* device = "";       ///< "cpu" or "cuda"
  int components = 0;            ///< of a compact code
  int64_t steps = 0, batch = 0;
  uint64_t seed = 0;
  double rate = 0;  ///< largest rate of the optimiser
  int resume = 0;   ///< 1: from the checkpoint, where there is one
};

/// How the library answers while it works and at the end.
struct LearnReply {
  void* self = nullptr;                            ///< passed back to both functions
  void (*say)(void* self, const char*) = nullptr;  ///< a line of progress
  int (*stopped)(void* self) = nullptr;            ///< 1 ends the work after the step
  int failed = 0;                                  ///< 1: error holds the message, kind its class
  ErrorKind kind = ErrorKind::kUsage;
  char error[1000] = "";
};

/// How a training task ended.
enum class TrainEnd : int {
  kStopped = 0,  ///< before its end; --resume goes on
  kFailing = 1,  ///< some fits miss the limits of their report
  kPassing = 2,  ///< all are within
};

/// Progress of a task and whether it is to end.
struct LearnHooks {
  std::function<void(const std::string&)> say;
  std::function<bool()> stopped;
};

/// Opens the library and trains. A generator's task ends as kPassing or kStopped.
/// @throws Error (usage) that names the places searched where the library is missing or of another
///         version, and whatever the task throws.
TrainEnd train_mtl(const TrainMtlTask& task, const LearnHooks& hooks);
TrainEnd train_autoencoder(const TrainGeneratorTask& task, const LearnHooks& hooks);
TrainEnd train_diffusion(const TrainGeneratorTask& task, const LearnHooks& hooks);

}  // namespace elastogen

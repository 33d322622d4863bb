// SPDX-License-Identifier: Apache-2.0
// Exports of the shared library elastogen_learn: C functions, no types of libtorch, no exceptions.

#pragma once

#include "network/law/learn_library.hpp"

extern "C" {

/// Version of the tasks that this library accepts: kLearnVersion of its build.
int elastogen_learn_version();

/// The task of `elastogen train mtl` (training/train_mtl.hpp).
int elastogen_train_mtl(const elastogen::TrainMtlTask* task, elastogen::LearnReply* reply);

/// The tasks of `elastogen train autoencoder` and `train diffusion`
/// (diffusion/train_generator.hpp).
int elastogen_train_autoencoder(const elastogen::TrainGeneratorTask* task,
                                elastogen::LearnReply* reply);
int elastogen_train_diffusion(const elastogen::TrainGeneratorTask* task,
                              elastogen::LearnReply* reply);
}

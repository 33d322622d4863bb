// SPDX-License-Identifier: Apache-2.0
#include "diffusion/train_entry_points.hpp"

#include "diffusion/train_generator.hpp"
#include "training/train_mtl.hpp"

#include <cstdio>
#include <exception>
#include <new>

namespace elastogen {
namespace {

void fail(LearnReply& reply, ErrorKind kind, const char* message) {
  reply.failed = 1;
  reply.kind = kind;
  std::snprintf(reply.error, sizeof reply.error, "%s", message);
}

/// Runs a task; an exception is written into the reply.
template <class Task>
int guarded(LearnReply& reply, const Task& task) {
  try {
    return int(task());
  } catch (const Error& error) {
    fail(reply, error.kind(), error.what());
  } catch (const std::bad_alloc&) {
    fail(reply, ErrorKind::kResources, "out of memory; fewer materials or samples need less");
  } catch (const std::exception& error) {  // libtorch's errors end with their place in its sources
    fail(reply, ErrorKind::kResources, error.what());
  }
  return 0;
}

TrainMtl from(const TrainMtlTask& task) {
  TrainMtl result;
  result.law = task.law, result.poisson = task.poisson;
  result.list = task.list, result.start = task.start, result.out = task.out;
  result.fit.steps = task.steps, result.fit.samples = task.samples;
  result.fit.seed = task.seed, result.fit.rate = task.rate;
  result.fit.device = task.device;
  result.fit.resume = task.resume != 0;
  result.fit.shared = task.shared != 0;
  result.last_layer = task.last_layer;
  return result;
}

TrainGenerator from(const TrainGeneratorTask& task) {
  TrainGenerator result;
  result.dataset = task.dataset, result.autoencoder = task.autoencoder, result.out = task.out;
  result.size = task.size, result.layers = task.layers;
  result.components = task.components;
  result.steps = task.steps, result.batch = task.batch;
  result.seed = task.seed, result.rate = task.rate;
  result.device = task.device;
  result.resume = task.resume != 0;
  return result;
}

/// Runs a task with hooks that call those of the reply.
template <class Task>
int answered(LearnReply* reply, const Task& task) {
  return guarded(*reply, [&] {
    FitHooks hooks;
    hooks.say = [&](const std::string& line) { reply->say(reply->self, line.c_str()); };
    hooks.stopped = [&] { return reply->stopped(reply->self) != 0; };
    return task(hooks);
  });
}

}  // namespace
}  // namespace elastogen

extern "C" {

[[gnu::visibility("default")]] int elastogen_learn_version() {
  return elastogen::kLearnVersion;
}

[[gnu::visibility("default")]] int elastogen_train_mtl(const elastogen::TrainMtlTask* task,
                                                       elastogen::LearnReply* reply) {
  using namespace elastogen;
  return answered(reply, [&](const FitHooks& hooks) { return train_mtl(from(*task), hooks); });
}

[[gnu::visibility("default")]] int elastogen_train_autoencoder(
    const elastogen::TrainGeneratorTask* task, elastogen::LearnReply* reply) {
  using namespace elastogen;
  return answered(reply,
                  [&](const FitHooks& hooks) { return train_autoencoder(from(*task), hooks); });
}

[[gnu::visibility("default")]] int elastogen_train_diffusion(
    const elastogen::TrainGeneratorTask* task, elastogen::LearnReply* reply) {
  using namespace elastogen;
  return answered(reply,
                  [&](const FitHooks& hooks) { return train_diffusion(from(*task), hooks); });
}
}

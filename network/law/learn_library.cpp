// SPDX-License-Identifier: Apache-2.0
#include "network/law/learn_library.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <vector>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "libelastogen_learn.so";

/// Where the library may lie: in the build folder of the program, or beside it as installed.
std::vector<std::string> places() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  return {(folder / "training" / kFile).string(), (folder / "../lib" / kFile).string()};
}

/// The library, open until the process ends: libtorch cannot be taken out again.
void* open_library() {
  std::string tried;
  for (const std::string& place : places()) {
    if (!fs::exists(place)) {
      tried += "\n  " + place + ": no such file";
      continue;
    }
    if (void* const library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
    tried += std::string("\n  ") + dlerror();
  }
  throw Error(concat("training needs the library elastogen_learn, which is not here:", tried));
}

/// A function of the library.
template <class Function>
Function* find(void* library, const char* name) {
  void* const address = dlsym(library, name);
  ELASTOGEN_CHECK(address, kFile, " has no function ", name);
  return reinterpret_cast<Function*>(address);
}

void* learn_library() {
  static void* const library = [] {
    void* const opened = open_library();
    const int version = find<int()>(opened, "elastogen_learn_version")();
    ELASTOGEN_CHECK(version == kLearnVersion, kFile, " is of version ", version, ", not ",
                    kLearnVersion, ": build both anew");
    return opened;
  }();
  return library;
}

/// Runs a task by a function of the library.
template <class Task>
TrainEnd run(const char* function, const Task& task, const LearnHooks& hooks) {
  LearnReply reply;
  reply.self = const_cast<LearnHooks*>(&hooks);
  reply.say = [](void* self, const char* line) { static_cast<LearnHooks*>(self)->say(line); };
  reply.stopped = [](void* self) { return static_cast<LearnHooks*>(self)->stopped() ? 1 : 0; };
  const int end = find<int(const Task*, LearnReply*)>(learn_library(), function)(&task, &reply);
  if (reply.failed) throw Error(reply.error, reply.kind);
  return TrainEnd(end);
}

}  // namespace

TrainEnd train_mtl(const TrainMtlTask& task, const LearnHooks& hooks) {
  return run("elastogen_train_mtl", task, hooks);
}

TrainEnd train_autoencoder(const TrainGeneratorTask& task, const LearnHooks& hooks) {
  return run("elastogen_train_autoencoder", task, hooks);
}

TrainEnd train_diffusion(const TrainGeneratorTask& task, const LearnHooks& hooks) {
  return run("elastogen_train_diffusion", task, hooks);
}

}  // namespace elastogen

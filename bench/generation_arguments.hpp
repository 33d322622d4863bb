// SPDX-License-Identifier: Apache-2.0
// Input of the benchmarks of generated weights: options, hidden layers, generator.

#pragma once

#include "core/error.hpp"
#include "diffusion/generate_weights.hpp"
#include "diffusion/hidden_hash.hpp"
#include "io/safe_file.hpp"
#include "training/hidden_layers.hpp"

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

namespace elastogen::bench {

struct Arguments {
  std::string folder;     ///< folder of hidden.tensors and, unless named, generator.tensors
  std::string generator;  ///< file of the generator
  std::string only;       ///< name of the only start
  std::string json;       ///< file to write
  std::string device = "cpu";
  int64_t count = 200;  ///< materials
  uint64_t seed = 1'000'003;
};

/// @throws Error (usage) with the usage text.
inline Arguments arguments_of(int argc, char** argv, const char* usage) {
  Arguments arguments;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    // the folder is the only word without a dash
    if (word[0] != '-') {
      arguments.folder = word;
      continue;
    }
    // every option has a value
    ELASTOGEN_CHECK(k + 1 < argc, word, " needs a value");
    const char* const value = argv[++k];
    if (word == "--count")
      arguments.count = std::atoll(value);
    else if (word == "--seed")
      arguments.seed = std::strtoull(value, nullptr, 10);
    else if (word == "--generator")
      arguments.generator = value;
    else if (word == "--only")
      arguments.only = value;
    else if (word == "--device")
      arguments.device = value;
    else if (word == "--json")
      arguments.json = value;
    else
      throw Error(concat("unknown option ", word));
  }
  ELASTOGEN_CHECK(!arguments.folder.empty() && arguments.count > 0, usage);
  return arguments;
}

inline std::vector<float> read_hidden(const std::string& folder,
                                      const std::string& name = kHiddenLayers) {
  const std::string path = folder + '/' + name;
  return decode_tensors(read_file(path, 1 << 24), path).get("neural_mtl", {kMtlParameters}).values;
}

/// The generator for these hidden layers.
inline WeightGenerator read_generator(const std::string& path, const std::vector<float>& hidden) {
  WeightGenerator generator(decode_tensors(read_file(path, 1 << 28), path), path);
  ELASTOGEN_CHECK(generator.hidden() == hidden_hash(hidden), path, " is for other hidden layers");
  return generator;
}

}  // namespace elastogen::bench

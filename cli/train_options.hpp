// SPDX-License-Identifier: Apache-2.0
// The options of `elastogen train` as structs.

#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace CLI {
class App;
}

namespace elastogen {

/// Task of `elastogen train mtl`.
struct TrainTask {
  std::string law = "neo-hookean";  ///< or a sum "0.3*stvk+0.7*hencky"
  double poisson = 0.45;
  std::string list;   ///< file of materials in place of one law
  std::string start;  ///< weight file to begin from
  std::string out;    ///< file of a single material, folder of a list
  int64_t steps = 3000, samples = 512;
  uint64_t seed = 1;
  double rate = 3e-3;
  std::string device = "cpu";
  int last_layer = 80;
  bool shared = false, resume = false, quiet = false;
};

/// Task of `elastogen train dataset`.
struct DatasetTask {
  int64_t count = 2000;
  int iterations = 40;  ///< largest number for a fit
  uint64_t seed = 1;
  std::string hidden;  ///< weight file with the hidden layers; empty: the shipped ones
  std::string out;
  bool resume = false, quiet = false;
};

/// Tasks of `elastogen train autoencoder` and `train diffusion`.
struct GeneratorTask {
  bool diffusion = false;  ///< else the autoencoder
  std::string dataset, autoencoder, out;
  std::string size = "compact", layers;
  int components = 64;
  int64_t steps = 0, batch = 0;
  uint64_t seed = 1;
  double rate = 0;
  std::string device = "cpu";
  bool resume = false, quiet = false;
};

using TrainVerb = std::variant<TrainTask, DatasetTask, GeneratorTask>;

/// Options of `train` while they are parsed.
class TrainOptions {
 public:
  void add(CLI::App& app);
  bool parsed() const;
  TrainVerb take() const;

 private:
  void add_mtl(CLI::App& verb);
  void add_dataset(CLI::App& verb);
  void add_autoencoder(CLI::App& verb);
  void add_diffusion(CLI::App& verb);

  TrainTask mtl_;
  DatasetTask dataset_;
  GeneratorTask autoencoder_, diffusion_;
  const CLI::App *verb_ = nullptr, *mtl_verb_ = nullptr, *dataset_verb_ = nullptr,
                 *autoencoder_verb_ = nullptr;
};

}  // namespace elastogen

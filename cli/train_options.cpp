// SPDX-License-Identifier: Apache-2.0
#include "cli/train_options.hpp"

#include <CLI/CLI.hpp>

namespace elastogen {
namespace {

/// Adds options that the trainings of all parts of a generator share.
void add_generator(CLI::App& verb, GeneratorTask& task) {
  verb.add_option("DATASET", task.dataset, "of elastogen train dataset (.h5)")->required();
  verb.add_option("-o,--out", task.out, "file of tensors")->required();
  verb.add_option("--size", task.size,
                  "compact: numbers that stresses are measured in; paper: fully connected, on all "
                  "17153 weights")
      ->capture_default_str();
  verb.add_option("--components", task.components, "numbers of a compact code")
      ->capture_default_str();
  verb.add_option("--steps", task.steps, "of the optimiser")->capture_default_str();
  verb.add_option("--batch", task.batch, "nets a step")->capture_default_str();
  verb.add_option("--rate", task.rate, "largest rate of the optimiser")->capture_default_str();
  verb.add_option("--seed", task.seed, "of start, batches and noise")->capture_default_str();
  verb.add_option("--device", task.device, "cpu or cuda")->capture_default_str();
  verb.add_flag("--resume", task.resume, "go on from the checkpoint beside the output");
  verb.add_flag("--quiet", task.quiet, "print errors only");
}

}  // namespace

void TrainOptions::add_mtl(CLI::App& verb) {
  CLI::App* mtl = verb.add_subcommand("mtl", "NeuralMTLs to elastic laws");
  mtl->add_option("--law", mtl_.law, "a law, or a sum like 0.3*stvk+0.7*hencky")
      ->capture_default_str();
  mtl->add_option("--poisson", mtl_.poisson, "Poisson's ratio, 0 to 0.499")->capture_default_str();
  mtl->add_option("--list", mtl_.list, "file of materials instead, lines: name, law, nu");
  mtl->add_option("--start", mtl_.start, "weight file of a like material to begin from");
  mtl->add_option("-o,--out", mtl_.out, "weight file; of a list a folder")->required();
  mtl->add_option("--steps", mtl_.steps, "of the optimiser")->capture_default_str();
  mtl->add_option("--last-layer", mtl_.last_layer, "iterations on the last layer after that")
      ->capture_default_str();
  mtl->add_option("--samples", mtl_.samples, "strains a step")->capture_default_str();
  mtl->add_option("--rate", mtl_.rate, "largest rate of the optimiser")->capture_default_str();
  mtl->add_option("--seed", mtl_.seed, "of start and strains")->capture_default_str();
  mtl->add_option("--device", mtl_.device, "cpu or cuda")->capture_default_str();
  mtl->add_flag("--shared-hidden", mtl_.shared, "one pair of hidden layers for all of a list");
  mtl->add_flag("--resume", mtl_.resume, "go on from the checkpoint beside the output");
  mtl->add_flag("--quiet", mtl_.quiet, "print errors only");
  mtl_verb_ = mtl;
}

void TrainOptions::add_dataset(CLI::App& verb) {
  CLI::App* dataset = verb.add_subcommand("dataset", "last layers of many random materials");
  dataset->add_option("-o,--out", dataset_.out, "HDF5 file")->required();
  dataset->add_option("--count", dataset_.count, "of materials")->capture_default_str();
  dataset->add_option("--iterations", dataset_.iterations, "of a fit, at most")
      ->capture_default_str();
  dataset->add_option("--seed", dataset_.seed, "of the materials")->capture_default_str();
  dataset->add_option("--hidden", dataset_.hidden,
                      "weight file with the hidden layers; else hidden.tensors as shipped");
  dataset->add_flag("--resume", dataset_.resume, "go on from the checkpoint beside the output");
  dataset->add_flag("--quiet", dataset_.quiet, "print errors only");
  dataset_verb_ = dataset;
}

void TrainOptions::add_autoencoder(CLI::App& verb) {
  autoencoder_.steps = 20000, autoencoder_.batch = 256, autoencoder_.rate = 1e-4;
  CLI::App* autoencoder =
      verb.add_subcommand("autoencoder", "nets as few numbers, of a dataset; compact: no steps");
  add_generator(*autoencoder, autoencoder_);
  autoencoder->add_option(
      "--layers", autoencoder_.layers,
      "sizes of the paper's hidden layers; default 8192,4096,2048,1024,512,256");
  autoencoder_verb_ = autoencoder;
}

void TrainOptions::add_diffusion(CLI::App& verb) {
  diffusion_.diffusion = true;
  diffusion_.steps = 60000, diffusion_.batch = 512, diffusion_.rate = 1e-3;
  CLI::App* diffusion =
      verb.add_subcommand("diffusion", "a generator of weights: codec, regression and denoiser");
  add_generator(*diffusion, diffusion_);
  diffusion->add_option("--autoencoder", diffusion_.autoencoder,
                        "file of elastogen train autoencoder; needed for --size paper");
}

void TrainOptions::add(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("train", "fits networks");
  verb->require_subcommand(1);
  add_mtl(*verb);
  add_dataset(*verb);
  add_autoencoder(*verb);
  add_diffusion(*verb);
  verb_ = verb;
}

bool TrainOptions::parsed() const {
  return verb_->parsed();
}

TrainVerb TrainOptions::take() const {
  if (mtl_verb_->parsed()) return mtl_;
  if (dataset_verb_->parsed()) return dataset_;
  return autoencoder_verb_->parsed() ? autoencoder_ : diffusion_;
}

}  // namespace elastogen

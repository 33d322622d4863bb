// SPDX-License-Identifier: Apache-2.0
#include "diffusion/train_generator.hpp"

#include "core/error.hpp"
#include "diffusion/autoencoder_torch.hpp"
#include "diffusion/denoiser_torch.hpp"
#include "diffusion/generate_weights.hpp"
#include "diffusion/hidden_hash.hpp"
#include "diffusion/start_fit.hpp"
#include "io/safe_file.hpp"
#include "training/fit_problem_torch.hpp"
#include "training/mtl_files.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace elastogen {
namespace {

constexpr int64_t kHeldOut = 10;      // one material in this many is held out
constexpr int64_t kMostJudged = 100;  // most held-out materials that are judged
constexpr int64_t kStrains = 4000;    // strains of their reports
constexpr int kIterations[] = {0, 1, 3, 10, 30};
constexpr int kChannels = 64;

/// A dataset in two parts: known and held out.
struct Parts {
  WeightDataset known, held;
};

WeightDataset read_dataset(const TrainGenerator& task) {
  return decode_dataset(read_file(task.dataset, int64_t{1} << 32), task.dataset);
}

Parts parts_of(const WeightDataset& data) {
  std::vector<int64_t> known, held;
  for (int64_t n = 0; n < data.count(); ++n)
    (n % kHeldOut == kHeldOut - 1 ? held : known).push_back(n);
  ELASTOGEN_CHECK(!held.empty(), "a dataset needs ", kHeldOut,
                  " materials, of which one is held "
                  "out; it has ",
                  data.count());
  return {dataset_rows(data, known), dataset_rows(data, held)};
}

bool is_paper(const TrainGenerator& task) {
  ELASTOGEN_CHECK(task.size == "compact" || task.size == "paper", "size '", task.size,
                  "' is not known; compact and paper are");
  ELASTOGEN_CHECK(!task.out.empty(), "name an output");
  return task.size == "paper";
}

/// Sizes of hidden layers: the paper's, or from a text.
std::vector<int64_t> layers_of(const std::string& text) {
  if (text.empty()) return {std::begin(kPaperLayers), std::end(kPaperLayers)};
  std::vector<int64_t> layers;
  const char *next = text.data(), *const last = text.data() + text.size();
  for (bool more = true; more;) {
    int64_t size = 0;
    const auto [end, error] = std::from_chars(next, last, size);
    ELASTOGEN_CHECK(error == std::errc() && size > 0 && (end == last || *end == ','),
                    "layers are sizes like 512,64,16, not '", text, "'");
    layers.push_back(size);
    more = end != last;
    next = end + 1;
  }
  return layers;
}

LoopOptions loop_of(const TrainGenerator& task) {
  LoopOptions loop;
  loop.steps = task.steps, loop.rate = task.rate;
  loop.checkpoint = task.out + ".part";
  loop.resume = task.resume;
  return loop;
}

/// All weights of the materials, (n, 17153).
Array<float> nets_of(const WeightDataset& data) {
  Array<float> nets(data.count(), kMtlParameters);
  for (int64_t n = 0; n < data.count(); ++n) {
    const std::vector<float> weights = data.weights(n);
    std::copy(weights.begin(), weights.end(), nets.row(n));
  }
  return nets;
}

/// Reports the quality of nets of held-out materials after encoding and decoding.
/// @param weights  (n, 17153) of the first n held-out materials.
void say_decoded(const WeightDataset& held, In<float> weights, TensorFile& file,
                 const FitHooks& hooks) {
  std::vector<double> median, p99;
  int64_t inside = 0;
  // judge each decoded net
  ReportOptions judged;
  judged.strains = kStrains;
  for (int64_t n = 0; n < weights.rows; ++n) {
    const FitReport report =
        fit_report(held.materials[size_t(n)], {weights.row(n), size_t(weights.cols)}, judged);
    inside += report.passes();
    median.push_back(report.stress_median), p99.push_back(report.stress_p99);
  }
  // medians over the nets
  const auto middle = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + int64_t(values.size()) / 2, values.end());
    return values[values.size() / 2];
  };
  const double of_median = middle(median), of_p99 = middle(p99);
  // into the file and to the user
  file.text["held_out.materials"] = std::to_string(weights.rows);
  file.text["held_out.inside"] = std::to_string(inside);
  file.text["held_out.stress.median"] = shortest_text(of_median);
  file.text["held_out.stress.p99"] = shortest_text(of_p99);
  hooks.say(concat("there and back, ", weights.rows, " held-out nets: ", inside,
                   " inside all limits, median net: stress median ", 100 * of_median, " %, p99 ",
                   100 * of_p99, " %"));
}

int64_t judged_count(const WeightDataset& held) {
  return std::min(kMostJudged, held.count());
}

/// The first rows of an array.
template <class T>
Span<const T> first_rows(const Array<T>& array, int64_t rows) {
  return {array.data(), rows, array.cols()};
}

TrainEnd write_output(const TrainGenerator& task, const TensorFile& file) {
  write_file(task.out, encode_tensors(file));
  std::error_code ignored;
  std::filesystem::remove(task.out + ".part", ignored);
  return TrainEnd::kPassing;
}

TrainEnd stopped(const FitHooks& hooks) {
  hooks.say("stopped; --resume goes on");
  return TrainEnd::kStopped;
}

TensorFile new_file(const char* form, const WeightDataset& data) {
  TensorFile file;
  file.text = {{"autoencoder.form", form}, {"generator.hidden", hidden_hash(data.hidden)}};
  return file;
}

TrainEnd compact_autoencoder(const TrainGenerator& task, const FitHooks& hooks) {
  const Parts parts = parts_of(read_dataset(task));
  const std::optional<WeightCodec> codec = make_codec(parts.known, task.components, hooks);
  if (!codec) return stopped(hooks);
  TensorFile file = new_file("compact", parts.known);
  codec->write(file);
  const int64_t count = judged_count(parts.held);
  const Array<double> codes = codec->encode(first_rows(parts.held.layers, count));
  Array<float> nets = nets_of(parts.held);
  for (int64_t n = 0; n < count; ++n) {
    const std::vector<float> layer = codec->decode({codes.row(n), size_t(codes.cols())});
    std::copy(layer.begin(), layer.end(), nets.row(n) + kMtlParameters - kMtlLast);
  }
  say_decoded(parts.held, first_rows(nets, count), file, hooks);
  return write_output(task, file);
}

TrainEnd paper_autoencoder(const TrainGenerator& task, const FitHooks& hooks) {
  const Parts parts = parts_of(read_dataset(task));
  AutoencoderOptions options;
  options.loop = loop_of(task);
  options.layers = layers_of(task.layers);
  options.batch = task.batch, options.seed = task.seed, options.device = task.device;
  const Array<float> known = nets_of(parts.known), held = nets_of(parts.held);
  Autoencoder autoencoder(known, options.layers, task.seed, fit_device(task.device));
  if (!autoencoder.train(known, options, hooks)) return stopped(hooks);
  TensorFile file = new_file("paper", parts.known);
  autoencoder.write(file);
  const double error = autoencoder.error(known), held_error = autoencoder.error(held);
  file.text["error.weights"] = shortest_text(error);
  file.text["held_out.error.weights"] = shortest_text(held_error);
  hooks.say(
      concat("error in standard deviations of the weights: ", error, ", held out ", held_error));
  const auto judged = first_rows(held, judged_count(parts.held));
  const Array<float> again = autoencoder.decode(autoencoder.encode(judged));
  say_decoded(parts.held, again, file, hooks);
  return write_output(task, file);
}

/// The file of an autoencoder of this form, for the hidden layers of the dataset.
TensorFile read_autoencoder(const TrainGenerator& task, const char* form,
                            const WeightDataset& data) {
  TensorFile file = decode_tensors(read_file(task.autoencoder), task.autoencoder);
  ELASTOGEN_CHECK_ASSET(file.text["autoencoder.form"] == form, task.autoencoder,
                        ": not an autoencoder of size ", form);
  ELASTOGEN_CHECK_ASSET(file.text["generator.hidden"] == hidden_hash(data.hidden), task.autoencoder,
                        ": for other hidden layers than the dataset");
  return file;
}

/// The codec from a file, or made from the dataset; no value if stopped.
std::optional<WeightCodec> codec_of(const TrainGenerator& task, const WeightDataset& data,
                                    const FitHooks& hooks) {
  if (task.autoencoder.empty()) return make_codec(data, task.components, hooks);
  return WeightCodec(read_autoencoder(task, "compact", data));
}

/// Columns divided by their scale; 0 where the scale is 0.
Array<double> scaled(Array<double> codes, const std::vector<double>& scale) {
  for (int64_t n = 0; n < codes.rows(); ++n)
    for (int c = 0; c < codes.cols(); ++c)
      codes(n, c) = scale[size_t(c)] > 0 ? codes(n, c) / scale[size_t(c)] : 0;
  return codes;
}

TrainEnd compact_diffusion(const TrainGenerator& task, const FitHooks& hooks) {
  const WeightDataset data = read_dataset(task);
  const std::optional<WeightCodec> codec = codec_of(task, data, hooks);
  // codes of the dataset, and a regression on them
  if (!codec) return stopped(hooks);
  Array<double> codes = codec->encode(data.layers);
  WeightRegression regression(data.features, codes);
  std::string lengths;
  for (const double length : regression.lengths()) lengths += concat(' ', length);
  hooks.say(concat("regression of ", data.count(), " materials, lengths", lengths));
  // a denoiser of the codes, if it gets steps
  std::optional<Denoiser> denoiser;
  if (task.steps > 0) {
    DenoiserOptions options;
    options.loop = loop_of(task);
    options.batch = task.batch, options.seed = task.seed, options.device = task.device;
    denoiser = train_denoiser(scaled(codes, codec->scale()), data.features, options, hooks);
    if (!denoiser) return stopped(hooks);
  }
  // one file for all, with the options
  const WeightGenerator generator({hidden_hash(data.hidden), *codec, std::move(regression),
                                   std::move(codes), std::move(denoiser)});
  TensorFile file = generator.file();
  file.text["trainer.materials"] = std::to_string(data.count());
  file.text["trainer.steps"] = std::to_string(task.steps);
  file.text["trainer.batch"] = std::to_string(task.batch);
  file.text["trainer.rate"] = shortest_text(task.rate);
  file.text["trainer.seed"] = std::to_string(task.seed);
  return write_output(task, file);
}

/// Fits held-out materials starting from these last layers, and reports how many pass.
void say_fits(const WeightDataset& held, In<float> nets, TensorFile& file, const FitHooks& hooks) {
  LastLayerOptions options;
  options.iterations = kIterations[std::size(kIterations) - 1];
  const LastLayer layer(held.hidden, options);
  ReportOptions judged;
  judged.strains = kStrains;
  int64_t inside[std::size(kIterations)] = {};
  for (int64_t n = 0; n < nets.rows; ++n) {
    const std::span<const float> start(nets.row(n) + kMtlParameters - kMtlLast, kMtlWidthOfLast);
    const std::vector<StartFit> fits =
        fit_from(layer, held.hidden, held.materials[size_t(n)], start, kIterations, judged);
    for (size_t k = 0; k < fits.size(); ++k) inside[k] += fits[k].report.passes();
  }
  file.text["held_out.materials"] = std::to_string(nets.rows);
  for (size_t k = 0; k < std::size(kIterations); ++k) {
    file.text[concat("held_out.inside.", kIterations[k])] = std::to_string(inside[k]);
    hooks.say(concat(kIterations[k], " iterations from samples, ", nets.rows,
                     " held-out materials: ", inside[k], " inside all limits"));
  }
}

TrainEnd paper_diffusion(const TrainGenerator& task, const FitHooks& hooks) {
  ELASTOGEN_CHECK(!task.autoencoder.empty(), "the paper's diffusion needs an --autoencoder");
  // the autoencoder's codes are square images
  const Parts parts = parts_of(read_dataset(task));
  const at::Device device = fit_device(task.device);
  const Autoencoder autoencoder(read_autoencoder(task, "paper", parts.known), device);
  const auto side = int(std::lround(std::sqrt(double(autoencoder.code_size()))));
  ELASTOGEN_CHECK(
      int64_t(side) * side == autoencoder.code_size() && autoencoder.net_size() == kMtlParameters,
      "codes of ", autoencoder.code_size(), " numbers are no square image, or nets of ",
      autoencoder.net_size(), " weights no NeuralMTLs");
  // train on standardised codes
  const Array<double> codes = autoencoder.encode(nets_of(parts.known));
  const FeatureScale spread = feature_scale(codes);
  Array<double> images = codes;
  for (int64_t n = 0; n < images.rows(); ++n)
    for (int c = 0; c < images.cols(); ++c)
      images(n, c) = (codes(n, c) - spread.mean[size_t(c)]) / spread.scale[size_t(c)];
  DenoiserOptions options;
  options.loop = loop_of(task);
  options.batch = task.batch, options.seed = task.seed, options.device = task.device;
  ConvDenoiser denoiser(side, kChannels, feature_scale(parts.known.features), task.seed, device);
  if (!denoiser.train(images, parts.known.features, options, hooks)) return stopped(hooks);

  // sample nets for held-out materials, and judge fits that start from them
  Array<double> samples(judged_count(parts.held), codes.cols());
  for (int64_t n = 0; n < samples.rows(); ++n) {
    const std::vector<double> x = denoiser.sample(parts.held.features.row(n), uint64_t(n));
    for (int c = 0; c < samples.cols(); ++c)
      samples(n, c) = spread.mean[size_t(c)] + spread.scale[size_t(c)] * x[size_t(c)];
  }
  // write
  TensorFile file = new_file("paper diffusion", parts.known);
  say_fits(parts.held, autoencoder.decode(samples), file, hooks);
  file.tensors.push_back({"latent.mean", {codes.cols()}, spread.mean});
  file.tensors.push_back({"latent.scale", {codes.cols()}, spread.scale});
  denoiser.write(file);
  return write_output(task, file);
}

}  // namespace

TrainEnd train_autoencoder(const TrainGenerator& task, const FitHooks& hooks) {
  return is_paper(task) ? paper_autoencoder(task, hooks) : compact_autoencoder(task, hooks);
}

TrainEnd train_diffusion(const TrainGenerator& task, const FitHooks& hooks) {
  ELASTOGEN_CHECK(task.steps >= 0, "steps must not be negative, got ", task.steps);
  return is_paper(task) ? paper_diffusion(task, hooks) : compact_diffusion(task, hooks);
}

}  // namespace elastogen

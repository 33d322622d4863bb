// SPDX-License-Identifier: Apache-2.0
#include "training/fit_checkpoint.hpp"

#include "core/error.hpp"
#include "core/tensor_file.hpp"
#include "io/safe_file.hpp"

#include <filesystem>

namespace elastogen {
namespace {

/// All settings that decide the numbers of a run.
std::string identity(const std::vector<FitMaterial>& materials, const FitOptions& o) {
  std::ostringstream text;
  text.precision(17);
  text << "steps " << o.steps << " samples " << o.samples << " seed " << o.seed << " rate "
       << o.rate << " warm-up " << o.warm_up << " start " << start_name(o)
       << (o.shared ? " shared" : "") << '\n';
  for (const FitMaterial& m : materials)
    text << m.name << ", " << law_text(m.terms) << ", " << m.poisson << '\n';
  return text.str();
}

}  // namespace

void write_checkpoint(const std::string& path, const std::vector<FitMaterial>& materials,
                      const FitOptions& options, const FitCheckpoint& checkpoint) {
  TensorFile file;
  file.text["checkpoint.of"] = identity(materials, options);
  file.text["checkpoint.step"] = std::to_string(checkpoint.step);
  for (size_t k = 0; k < checkpoint.numbers.size(); ++k)
    file.tensors.push_back(
        {std::to_string(k), {int64_t(checkpoint.numbers[k].size())}, checkpoint.numbers[k]});
  write_file(path, encode_tensors(file));
}

std::optional<FitCheckpoint> read_checkpoint(const std::string& path,
                                             const std::vector<FitMaterial>& materials,
                                             const FitOptions& options, size_t parts) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const TensorFile file = decode_tensors(read_file(path), path);
  const auto of = file.text.find("checkpoint.of");
  const auto step = file.text.find("checkpoint.step");
  ELASTOGEN_CHECK_ASSET(of != file.text.end() && step != file.text.end() &&
                            of->second == identity(materials, options),
                        path, ": a checkpoint of other materials or options");
  FitCheckpoint checkpoint;
  checkpoint.step = std::stoll(step->second);
  for (const Tensor& tensor : file.tensors) checkpoint.numbers.push_back(tensor.values);
  ELASTOGEN_CHECK_ASSET(checkpoint.numbers.size() == parts, path, ": ", parts,
                        " tensors are needed, got ", checkpoint.numbers.size());
  return checkpoint;
}

}  // namespace elastogen

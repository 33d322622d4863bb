// SPDX-License-Identifier: Apache-2.0
#include "bench/bench.hpp"

#include "core/cuda/card.hpp"
#include "core/error.hpp"

#include <nlohmann/json.hpp>

namespace elastogen::bench {

const std::vector<std::string>& part_names() {
  static const std::vector<std::string> names = {"ceilings", "kernels",  "step",      "error-time",
                                                 "tip",      "baseline", "particles", "startup"};
  return names;
}

Device resolved(Device asked) {
  if (asked == Device::kCpu || (asked == Device::kAuto && !cuda::has_device())) return Device::kCpu;
  if (!cuda::has_device())
    throw Error("there is no CUDA device, or none that this build can use: leave out --device cuda",
                ErrorKind::kDevice);
  return Device::kCuda;
}

Json measure(const std::string& part, const BenchTask& task, const CopyRates& rates) {
  if (part == "ceilings") return measure_ceilings(task);
  if (part == "kernels") return measure_kernels(task, rates);
  if (part == "step") return measure_steps(task, rates);
  if (part == "error-time") return measure_error_time(task);
  if (part == "tip") return measure_tip(task);
  if (part == "baseline") return measure_baseline(task);
  if (part == "particles") return measure_particles(task, rates);
  if (part == "startup") return measure_startup(task);
  throw Error(concat("unknown part '", part,
                     "'; known are ceilings, kernels, step, error-time, tip, baseline, particles, "
                     "startup"));
}

}  // namespace elastogen::bench

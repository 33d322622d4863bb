// SPDX-License-Identifier: Apache-2.0
#include "io/animation_writer.hpp"

#include "core/error.hpp"
#include "io/glb_writer.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace elastogen {

std::unique_ptr<AnimationWriter> AnimationWriter::create(const std::string& path,
                                                         const Asset& asset, const Surface& surface,
                                                         const AnimationOptions& options) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  ELASTOGEN_CHECK(ending == ".glb", path, ": the output must end in .glb, got \"", ending, '"');
  ELASTOGEN_CHECK(options.fps > 0 && options.modal_error > 0,
                  "fps and modal_error must be positive, got ", options.fps, " and ",
                  options.modal_error);
  return make_glb_writer(path, asset, surface, options);
}

}  // namespace elastogen

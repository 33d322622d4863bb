// SPDX-License-Identifier: Apache-2.0
// Any text as a scene file: refused as a usage error, or a scene whose JSON is the same scene.

#include "io/scene_file.hpp"
#include "tests/fuzz/harness.hpp"

#include <cstddef>
#include <cstdint>

namespace elastogen {
namespace {

/// A scene as JSON, or the reason why there is none.
std::string read(std::string_view text, const std::string& name, bool& is_scene) {
  try {
    is_scene = true;
    return scene_json(check_scene(text, name));
  } catch (const Error& error) {
    fuzz::require_kind(error, ErrorKind::kUsage);
    is_scene = false;
    return error.what();
  }
}

}  // namespace
}  // namespace elastogen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  bool is_scene = false, again = false;
  const std::string scene = read(text, FUZZ_NAME, is_scene);
  fuzz::require(read(text, FUZZ_NAME, again) == scene, "a scene reads the same twice");
  if (is_scene)
    fuzz::require(read(scene, "fuzz.json", again) == scene && again, "its JSON is the same scene");
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "io/animation_writer.hpp"

#include "core/error.hpp"
#include "io/glb_writer.hpp"
#include "io/particle_vtu_writer.hpp"
#include "io/ply_writer.hpp"
#include "io/point_cache_writer.hpp"
#include "io/safe_file.hpp"
#include "io/vtu_writer.hpp"

#include <filesystem>

namespace elastogen {

std::unique_ptr<AnimationWriter> AnimationWriter::create(const std::string& path,
                                                         const Asset& asset, const Surface& surface,
                                                         const AnimationOptions& options) {
  // endings that have no writer here
  const std::string ending = ending_of(path);
  const bool known = ending == "glb" || ending == "ply" || ending == "pc2" || ending == "pvd";
  ELASTOGEN_CHECK(ending != "png", path, ": pictures are written by the command alone");
  ELASTOGEN_CHECK(
      ending != "obj" && ending != "vdb", path, ": .", ending,
      " shows the surface of particles, and this run has none; .glb or .ply shows a mesh");
  ELASTOGEN_CHECK(known, path,
                  ": the output must end in .glb, .ply, .pc2, .pvd or .png, of "
                  "particles also .obj or .vdb, got \".",
                  ending, '"');
  // options out of range
  ELASTOGEN_CHECK(options.fps > 0 && options.modal_error > 0 && options.max_targets >= 4,
                  "fps and modal_error must be positive and max_targets 4 at least, got ",
                  options.fps, ", ", options.modal_error, " and ", options.max_targets);
  // one writer for each ending; a GLB cannot hold points
  if (ending == "pc2") return make_point_cache_writer(path, asset, surface);
  if (ending == "ply") return make_ply_writer(path, asset, surface, options.particles);
  if (ending == "pvd" && options.particles) return make_particle_vtu_writer(path, options);
  if (ending == "pvd") return make_vtu_writer(path, options);
  const std::string name = std::filesystem::path(path).replace_extension().string();
  ELASTOGEN_CHECK(!asset.points && !asset.splats, path,
                  ": a GLB shows meshes; points and splats are written as ", name,
                  ".ply (one file a frame) or ", name, ".pc2");
  return make_glb_writer(path, asset, surface, options);
}

}  // namespace elastogen

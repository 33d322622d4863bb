// SPDX-License-Identifier: Apache-2.0
#include "io/output_findings.hpp"

#include "core/error.hpp"
#include "io/ply_mesh.hpp"
#include "io/safe_file.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Paths of outputs with one of the endings, "" if there is none.
std::string outputs_with(const std::vector<std::string>& paths,
                         std::initializer_list<std::string_view> endings) {
  std::string list;
  for (const std::string& path : paths)
    if (std::ranges::find(endings, ending_of(path)) != endings.end())
      list += (list.empty() ? "" : ", ") + path;
  return list;
}

std::string own_columns_of(const Asset& asset, int64_t& count) {
  std::string list;
  for (const Mesh& mesh : asset.meshes)
    for (const OwnColumn& own : mesh.own) {
      list += (list.empty() ? "" : ", ") + own.name;
      ++count;
    }
  return list;
}

}  // namespace

std::vector<Finding> output_findings(const Asset& asset, const Surface& surface,
                                     const std::vector<std::string>& paths) {
  std::vector<Finding> findings;
  // columns that only PLY can hold
  const FileOrder order = file_order(asset, surface);
  const std::string plain = outputs_with(paths, {"glb", "pc2", "pvd"});
  int64_t columns = 0;
  const std::string names = own_columns_of(asset, columns);
  if (columns > 0 && !plain.empty())
    findings.push_back({"own-columns", columns,
                        concat("columns of the vertices have no place in ", plain, ": ", names)});
  // corners that differ in their normal share a vertex in PLY
  const std::string ply = outputs_with(paths, {"ply"});
  if (!ply.empty() && !asset.points && !asset.splats) {
    const int64_t vertices = PlyMesh(ply, asset, surface, order).without_normal();
    if (vertices > 0)
      findings.push_back(
          {"corner-normals", vertices,
           concat("vertices have several normals or none, PLY one for each: ", ply)});
  }
  // PC2 is float32, far from the origin too coarse
  const std::string rounded = outputs_with(paths, {"pc2"});
  if (!rounded.empty() && is_float32_coarse(order.rest))
    findings.push_back(
        {"rounded-positions", int64_t(order.rest.size()),
         concat("positions lie so far out that the float32 numbers of ", rounded,
                " go by steps of ", float32_step(order.rest), " there, in the unit of the file")});
  return findings;
}

}  // namespace elastogen

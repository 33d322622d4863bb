// SPDX-License-Identifier: Apache-2.0
#include "io/finding.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr Severity kNote = Severity::kNote, kWarning = Severity::kWarning;

constexpr FindingKind kKinds[] = {
    // numbers that cannot be used
    {"bad-uvs", kWarning, "set to 0", "repair the file"},
    {"bad-normals", kWarning, "set to (0, 0, 1)", "repair the file"},
    {"zero-normals", kWarning, "taken from the faces around", "repair the file"},
    {"long-normals", kNote, "scaled to length one", ""},
    {"bad-colours", kWarning, "set to white", "repair the file"},
    {"bad-points", kWarning, "left out, of the output too", "repair the file"},
    {"bad-splats", kWarning, "left out, of the output too", "repair the file"},
    {"bad-rotations", kWarning, "set to no rotation", "repair the file"},
    {"bad-harmonics", kWarning, "set to 0", "repair the file"},
    {"splat-colours", kNote, "taken as colours that do not depend on the view", ""},
    {"splat-opacity", kWarning, "taken as opaque", "save the splats with an opacity"},
    {"linear-splats", kWarning, "taken as they are", "--splat-scales log"},
    {"harmonics", kWarning, "left out; the colours do not depend on the view",
     "save the splats as an uncompressed PLY"},

    // properties of the surface
    {"zero-area", kNote, "passed over by the physics; the output keeps them", ""},
    {"duplicate-faces", kNote, "one of each counts for the physics; the output keeps them", ""},
    {"double-sided", kNote, "one of them or the pair counts for the physics; the output keeps both",
     ""},
    {"duplicate-vertices", kNote, "joined for the physics; the output keeps them", ""},
    {"unreferenced", kNote, "passed over by the physics; they move with the nearest voxel", ""},
    {"open", kNote, "filled by the winding number, or as sheets where nothing is bounded", ""},
    {"non-manifold", kNote, "the inside is found by the winding number", ""},
    {"mixed-winding", kNote, "turned where that makes neighbours agree, for the physics", ""},
    {"turned-faces", kNote, "turned, for the physics; the output keeps its winding", ""},
    {"flipped", kNote, "taken as the inside's border all the same; the output keeps its winding",
     ""},
    {"pieces", kNote, "left as it is", ""},

    // properties of the solid
    {"sheet", kWarning, "filled as layers as thick as a voxel, or --thickness",
     "--thickness, or close the surface"},
    {"overlaps", kNote, "what lies in two solids is filled once, by the winding number", ""},
    {"winding-number", kWarning, "the inside is found by the winding number", "close the surface"},
    {"joined-pieces", kWarning, "joined by the voxels between them", "--part-pieces"},
    {"loose-pieces", kWarning, "each moves by itself", "pin them, or join them in the file"},
    {"hinges", kWarning, "they turn there without stiffness", "take more --voxels"},
    {"splats", kNote, "the solid is built of the others; they move with what is nearest", ""},
    {"floaters", kWarning, "the solid is built of the others; they move with what is nearest",
     "remove them from the file"},
    {"coarse", kWarning, "the solid is built with a wider spacing", "take fewer points"},
    {"shell", kWarning, "filled as a shell", "--thickness, or scan it from all sides"},

    {"carried-columns", kNote, "written to .ply outputs as they are, not to others", ""},

    // parts of the file that are left out
    {"lost-columns", kWarning, "left out", "save them as numbers of 32 bits at most"},
    {"short-face", kWarning, "left out", "repair the file"},
    {"free-form", kWarning, "left out", "save polygons"},
    {"not-triangles", kNote,
     "left out of the physics; beside triangles of a mesh they move with the nearest voxel",
     "save triangles"},
    {"tangents", kNote, "left out where the mesh moves; clients compute those of the moved surface",
     ""},
    {"points-and-lines", kWarning, "left out", "save triangles"},
    {"scene-roots", kWarning,
     "they stand without their parent, or below the root that is named too",
     "name the parents in the scene"},
    {"instances", kNote, "each becomes a node and is simulated by itself", ""},
    {"instance-attributes", kWarning, "left out", ""},
    {"hidden", kNote, "not simulated; the output keeps them as they are",
     "make them visible in the file"},
    {"animations", kWarning, "left out; the simulated one takes their place", ""},
    {"skins", kWarning, "their skins are left out", ""},
    {"morph-weights", kNote, "the shape that the file shows is simulated", ""},
    {"morph-targets", kWarning, "they are left out", "apply them before saving"},
    {"embedded-texture", kWarning, "shown without", "save as GLB"},
    {"missing-texture", kWarning, "shown without", "put the image beside the asset"},
    {"missing-uvs", kWarning, "shown in the base colour of the material", "unwrap them"},
    {"missing-normals", kWarning, "the normals of the file are not used",
     "save a normal at every corner"},
    {"missing-material-file", kWarning, "shown in the default colour", "put it beside the asset"},
    {"unread-material-file", kWarning, "shown in the default colour", "save it as UTF-8"},
    {"face-colours", kWarning, "left out", "save colours of one kind"},
    {"left-out-properties", kWarning, "left out", ""},
    {"extra-bytes", kWarning, "left out", "repair the counts of the header"},
    {"header-lines", kNote, "passed over", ""},
    {"own-columns", kWarning, "left out", "write .ply"},
    {"corner-normals", kWarning, "its normals are left out", "write .glb"},
    {"rounded-positions", kWarning, "rounded to that",
     "move the asset to the origin, or write .glb, or .ply of a mesh or of points"},
    {"turned-tetrahedra", kNote, "two corners of each were swapped", ""},
    {"skipped-elements", kWarning, "left out", "save tetrahedra"},
    {"unused-nodes", kNote, "left out", ""},
    {"vdb-grids", kWarning, "left out", "--grid"},
};

}  // namespace

std::string_view severity_name(Severity severity) {
  return severity == kWarning ? "warning" : "note";
}

std::span<const FindingKind> finding_kinds() {
  return kKinds;
}

const FindingKind& kind_of(const Finding& finding) {
  const auto* kind = std::ranges::find(kKinds, finding.what, &FindingKind::what);
  ELASTOGEN_CHECK(kind != std::end(kKinds), "no row for the finding \"", finding.what, '"');
  return *kind;
}

std::string finding_line(const Finding& finding) {
  const FindingKind& kind = kind_of(finding);
  std::string line =
      concat(finding.what, " (", finding.count, "): ", finding.text, "; ", kind.done);
  if (!kind.change.empty()) line += concat("; to change that: ", kind.change);
  return line;
}

std::vector<std::string> finding_lines(const std::vector<Finding>& findings, Severity severity) {
  std::vector<std::string> lines;
  for (const Finding& finding : findings)
    if (kind_of(finding).severity == severity) lines.push_back(finding_line(finding));
  return lines;
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_boundary.hpp"

#include "core/error.hpp"
#include "core/held_nodes.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/elastic_body.hpp"
#include "mpm_fem/fem/mesh_pieces.hpp"
#include "scene/fem_holders.hpp"
#include "scene/loads.hpp"
#include "scene/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace elastogen {
namespace {

/// An option that holds or moves nodes of the grid.
struct Claim {
  std::string text;
  Array<uint8_t> nodes;
};

/// @throws Error (usage) naming both claims if they have a node in common.
void check_apart(const Claim& a, const Claim& b, const VoxelGrid& grid) {
  for (int64_t n = 0; n < grid.node_count(); ++n)
    if (a.nodes(n) && b.nodes(n))
      throw Error(
          fmt::format("{} and {} contradict each other: both have the node at ({:.4g}, "
                      "{:.4g}, {:.4g}) m",
                      a.text, b.text, grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)));
}

void check_contradictions(const Setup& setup, const RunDescription& run) {
  const VoxelGrid& grid = setup.scene.grid;
  std::vector<Claim> claims;
  const auto claim = [&](const char* option, const std::string& text, const Selection& selection) {
    claims.push_back({fmt::format("{} '{}'", option, text), selected_nodes(setup, selection)});
  };
  for (const Pin& pin : run.pins) claim("--pin", pin.text, pin.selection);
  for (const Hold& hold : run.holds) claim("--hold", hold.text, hold.selection);
  for (const Move& move : run.moves) {
    claim("--move", move.text, move.selection);
    for (size_t k = 0; k + 1 < claims.size(); ++k) check_apart(claims[k], claims.back(), grid);
  }
}

void add_holds(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  scene.fixed = Array<uint8_t>(scene.mesh.rest.rows(), 3);
  for (int64_t n = 0; n < scene.fixed.rows(); ++n)
    scene.fixed(n, 2) = fem::is_plane(scene.mesh.element);
  const Array<uint8_t> pinned = nodes_with_holders(setup, scene.mesh).pinned;
  for (int64_t n = 0; n < pinned.rows(); ++n)
    if (pinned(n) == kPinnedNode) std::fill_n(scene.fixed.row(n), 3, uint8_t(1));
  for (const Hold& hold : run.holds) {
    const Array<uint8_t> nodes = with_middles(selected_nodes(setup, hold.selection), scene.mesh);
    for (int64_t n = 0; n < nodes.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        if (nodes(n) && hold.axes[size_t(d)]) scene.fixed(n, d) = 1;
  }
}

/// The nodes of a mesh and what holds them.
struct HeldMesh {
  explicit HeldMesh(Scene mesh_nodes) : nodes(std::move(mesh_nodes)), held(nodes) {}
  Scene nodes;
  HeldNodes held;
};

/// Of statics a load factor of 1 is the end of all paths.
void add_moves(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  if (run.moves.empty()) return;
  const double per_time = run.fem->statics ? end_of_moves(run) : 1;
  for (const Move& move : run.moves) scene.paths.push_back(move.path);
  const auto mesh = std::make_shared<HeldMesh>(nodes_with_holders(setup, scene.mesh));
  scene.motion = [mesh, per_time](double time, Out<double> u) {
    mesh->held.set_time(per_time * time);
    mesh->held.place_pinned(u.data);
  };
  if (!mesh->held.moves_dependent()) return;
  scene.dependent_motion = [mesh, per_time](double time, Out<double> offset) {
    mesh->held.set_time(per_time * time);
    for (int64_t i = 0; i < offset.rows; ++i)
      std::ranges::copy(mesh->held.offset(i), offset.row(i));
  };
}

/// In statics forces are those at the end of their path, times the load factor, like tractions.
void add_timed_forces(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  if (run.forces.empty()) return;
  const std::vector<TimedForce> forces = fem_forces(setup, run, scene);
  const auto add = [](const TimedForce& force, const Vec3& F, Out<double> load) {
    for (int64_t n = 0; n < load.rows; ++n)
      for (int d = 0; d < 3; ++d) load(n, d) += force.share(n) * F[size_t(d)];
  };
  if (!run.fem->statics) {
    for (const TimedForce& force : forces) scene.paths.push_back(force.force);
    scene.force = [forces, add](double time, Out<double> load) {
      for (const TimedForce& force : forces) add(force, offset_at(force.force, time), load);
    };
    return;
  }
  if (scene.traction.empty()) scene.traction = Array<double>(scene.mesh.rest.rows(), 3);
  for (const TimedForce& force : forces) add(force, force.force.keys.back().offset, scene.traction);
}

/// A piece of the mesh.
struct Piece {
  int64_t nodes = 0;
  Box box;                        // at rest [m]
  std::array<bool, 3> held = {};  // whether something holds or moves it along x, y, z
};

std::vector<Piece> pieces_of(const fem::FemScene& scene) {
  const Array<int32_t> piece = fem::mesh_pieces(scene.mesh);
  std::vector<Piece> pieces;
  for (int64_t n = 0; n < piece.rows(); ++n) {
    if (piece(n) < 0) continue;
    pieces.resize(std::max(pieces.size(), size_t(piece(n)) + 1));
    Piece& own = pieces[size_t(piece(n))];
    ++own.nodes;
    own.box.add({scene.mesh.rest(n, 0), scene.mesh.rest(n, 1), scene.mesh.rest(n, 2)});
    for (int d = 0; d < 3; ++d) own.held[size_t(d)] |= scene.fixed(n, d) != 0;
  }
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    pieces[size_t(piece(scene.dependent.node(i)))].held = {true, true, true};
  return pieces;
}

}  // namespace

std::vector<TimedForce> fem_forces(const Setup& setup, const RunDescription& run,
                                   const fem::FemScene& scene) {
  const Array<double> mass = fem::ElasticBody(scene.mesh, scene.materials).lumped_mass();
  return timed_forces(setup, run, scene.mesh, mass);
}

double end_of_moves(const RunDescription& run) {
  double end = 0;
  for (const Move& move : run.moves) end = std::max(end, move.path.keys.back().time);
  return end;
}

void add_boundary(const Setup& setup, const RunDescription& run, const fem::ElementMesh& whole,
                  fem::FemScene& scene) {
  check_contradictions(setup, run);
  scene.dependent = nodes_with_holders(setup, scene.mesh).dependent;
  add_holds(setup, run, scene);
  add_moves(setup, run, scene);
  // what a pin holds at its border follows that
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    std::fill_n(scene.fixed.row(scene.dependent.node(i)), 3, uint8_t(0));
  scene.traction = surface_loads(setup, run, whole);
  add_timed_forces(setup, run, scene);
  if (setup.scene.wind.blows()) scene.in_wind = &setup.scene;
}

std::vector<std::string> unheld_pieces(const fem::FemScene& scene) {
  constexpr size_t kMost = 4;
  std::vector<std::string> sentences;
  size_t more = 0;
  for (const Piece& piece : pieces_of(scene)) {
    std::string free;
    for (size_t d = 0; d < 3; ++d)
      if (!piece.held[d]) free += fmt::format("{}{}", free.empty() ? "" : ", ", "xyz"[d]);
    if (free.empty()) continue;
    const Box& box = piece.box;
    if (sentences.size() < kMost)
      sentences.push_back(fmt::format(
          "--static: nothing holds the piece of {} nodes in {:.4g}..{:.4g}, {:.4g}..{:.4g}, "
          "{:.4g}..{:.4g} m along {}",
          piece.nodes, box.lower[0], box.upper[0], box.lower[1], box.upper[1], box.lower[2],
          box.upper[2], free));
    else
      ++more;
  }
  if (more > 0)
    sentences.push_back(fmt::format("--static: nor {} more piece{}", more, more == 1 ? "" : "s"));
  return sentences;
}

}  // namespace elastogen

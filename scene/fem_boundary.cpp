// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_boundary.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/mesh_pieces.hpp"
#include "mpm_fem/fem/surface_load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// The given nodes of the grid, and the middles of edges between two of them.
Array<uint8_t> with_middles(const Array<uint8_t>& grid_nodes, const fem::ElementMesh& mesh) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  Array<uint8_t> nodes(mesh.rest.rows());
  std::copy_n(grid_nodes.data(), grid_nodes.rows(), nodes.data());
  for (int64_t e = 0; e < mesh.elements.rows() && mesh.elements.cols() == 10; ++e)
    for (int k = 0; k < 6; ++k) {
      const int32_t a = mesh.elements(e, kEdges[k][0]), b = mesh.elements(e, kEdges[k][1]);
      if (grid_nodes(a) && grid_nodes(b)) nodes(mesh.elements(e, 4 + k)) = 1;
    }
  return nodes;
}

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
    claims.push_back({fmt::format("{} '{}'", option, text),
                      select_nodes(grid, selection, setup.body.surface.box)});
  };
  for (const Pin& pin : run.pins) claim("--pin", pin.text, pin.selection);
  for (const Hold& hold : run.holds) claim("--hold", hold.text, hold.selection);
  for (const Move& move : run.moves) {
    claim("--move", move.text, move.selection);
    for (size_t k = 0; k + 1 < claims.size(); ++k) check_apart(claims[k], claims.back(), grid);
  }
}

/// A prescribed motion of nodes.
struct Motion {
  std::vector<int32_t> nodes;
  std::vector<Vec3> rest;  ///< rest position of each [m]
  bool turns = false;
  Vec3 centre = {};  ///< centre of a turn [m]
  Collider frame;    ///< used for its path: offsets [m] or rotation vectors [rad]
};

/// r turned by a rotation vector (Rodrigues).
Vec3 turned(const Vec3& r, const Vec3& rotation) {
  const double angle = std::hypot(rotation[0], rotation[1], rotation[2]);
  if (angle == 0) return r;
  Vec3 n, result;
  for (size_t d = 0; d < 3; ++d) n[d] = rotation[d] / angle;
  const double along = n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
  for (size_t d = 0; d < 3; ++d) {
    const size_t e = (d + 1) % 3, f = (d + 2) % 3;
    result[d] = r[d] * std::cos(angle) + (n[e] * r[f] - n[f] * r[e]) * std::sin(angle) +
                n[d] * along * (1 - std::cos(angle));
  }
  return result;
}

/// Writes the displacements at a time [m].
void displace(const Motion& motion, double time, Out<double> u) {
  const Vec3 offset = offset_at(motion.frame, time);
  for (size_t k = 0; k < motion.nodes.size(); ++k) {
    Vec3 moved = offset;
    if (motion.turns) {
      Vec3 arm;
      for (size_t d = 0; d < 3; ++d) arm[d] = motion.rest[k][d] - motion.centre[d];
      moved = turned(arm, offset);
      for (size_t d = 0; d < 3; ++d) moved[d] -= arm[d];
    }
    std::copy(moved.begin(), moved.end(), u.row(motion.nodes[k]));
  }
}

Motion make_motion(const Move& move, const Setup& setup, const fem::ElementMesh& mesh) {
  const PlacedBox& box = setup.body.surface.box;
  const Array<uint8_t> selected =
      with_middles(select_nodes(setup.scene.grid, move.selection, box), mesh);
  Motion motion;
  motion.turns = move.turns;
  motion.frame.path = move.path;
  if (move.turns)
    for (size_t d = 0; d < 3; ++d) motion.centre[d] = coordinate(move.turn_centre[d], int(d), box);
  for (int64_t n = 0; n < selected.rows(); ++n) {
    if (!selected(n)) continue;
    motion.nodes.push_back(int32_t(n));
    motion.rest.push_back({mesh.rest(n, 0), mesh.rest(n, 1), mesh.rest(n, 2)});
  }
  return motion;
}

void add_holds(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  scene.fixed = Array<uint8_t>(scene.mesh.rest.rows(), 3);
  for (int64_t n = 0; n < scene.fixed.rows(); ++n)
    scene.fixed(n, 2) = fem::is_plane(scene.mesh.element);
  const Array<uint8_t> pinned = pinned_nodes(setup.scene, scene.mesh);
  for (int64_t n = 0; n < pinned.rows(); ++n)
    if (pinned(n) == kPinnedNode) std::fill_n(scene.fixed.row(n), 3, uint8_t(1));
  for (const Hold& hold : run.holds) {
    const Array<uint8_t> nodes = with_middles(
        select_nodes(setup.scene.grid, hold.selection, setup.body.surface.box), scene.mesh);
    for (int64_t n = 0; n < nodes.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        if (nodes(n) && hold.axes[size_t(d)]) scene.fixed(n, d) = 1;
  }
}

void add_tractions(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  const PlacedBox& box = setup.body.surface.box;
  for (const Traction& traction : run.tractions) {
    const Array<uint8_t> nodes =
        with_middles(select_nodes(setup.scene.grid, traction.selection, box), scene.mesh);
    const Array<double> load = traction.pressure
                                   ? fem::pressure_load(scene.mesh, nodes, *traction.pressure)
                                   : fem::surface_load(scene.mesh, nodes, traction.force);
    if (load.empty())
      throw Error(fmt::format(
          "--traction '{}': no face of the body has all its nodes in the selection; the asset "
          "spans {:.4g}..{:.4g}, {:.4g}..{:.4g}, {:.4g}..{:.4g} m",
          traction.text, box.lower[0], box.upper[0], box.lower[1], box.upper[1], box.lower[2],
          box.upper[2]));
    if (scene.traction.empty()) scene.traction = Array<double>(load.rows(), 3);
    for (int64_t k = 0; k < load.size(); ++k) scene.traction.data()[k] += load.data()[k];
  }
}

void add_moves(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  if (run.moves.empty()) return;
  std::vector<Motion> motions;
  double end = 0;  // time of the last key
  for (const Move& move : run.moves) {
    end = std::max(end, move.path.back().time);
    motions.push_back(make_motion(move, setup, scene.mesh));
    for (const int32_t n : motions.back().nodes) std::fill_n(scene.fixed.row(n), 3, uint8_t(1));
  }
  const double per_time = run.fem->statics ? end : 1;
  scene.motion = [motions = std::move(motions), per_time](double time, Out<double> u) {
    for (const Motion& motion : motions) displace(motion, per_time * time, u);
  };
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

Array<uint8_t> pinned_nodes(const Scene& scene, const fem::ElementMesh& mesh) {
  return with_middles(scene.pinned, mesh);
}

void add_boundary(const Setup& setup, const RunDescription& run, fem::FemScene& scene) {
  check_contradictions(setup, run);
  scene.dependent = setup.scene.dependent;
  add_holds(setup, run, scene);
  add_moves(setup, run, scene);
  // what a pin holds at its border follows that
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    std::fill_n(scene.fixed.row(scene.dependent.node(i)), 3, uint8_t(0));
  add_tractions(setup, run, scene);
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

// SPDX-License-Identifier: Apache-2.0
// The scene of the finite element integrators.

#pragma once

#include "core/dependent_nodes.hpp"
#include "mpm_fem/contact/collider_contact.hpp"
#include "mpm_fem/fem/element_mesh.hpp"
#include "mpm_fem/materials/solid.hpp"

#include <functional>
#include <vector>

namespace elastogen {
struct Scene;
}

namespace elastogen::fem {

/// Newmark: the average acceleration scheme, beta = 1/4, gamma = 1/2, which keeps the energy of
/// linear problems. Steps of StageFem: sdirk2 with steps of dt, auto with as many within each dt as
/// the time error asks for.
enum class Scheme : uint8_t { kEuler, kBdf2, kNewmark, kSdirk2, kAuto };
enum class Mass : uint8_t { kLumped, kConsistent };

struct FemScene {
  ElementMesh mesh;
  std::vector<Material> materials;
  std::vector<Yield> yields;  ///< of each material; empty: all are elastic
  Array<double> mass;      ///< lumped mass of each node [kg], (nodes, 1); empty: that of the mesh
  Vec3 gravity = {};       ///< [m/s^2]
  Array<uint8_t> fixed;    ///< 1 where a component's displacement is prescribed, (nodes, 3)
  Array<double> traction;  ///< dead load on each node [N], (nodes, 3); empty: none
  /// Writes the prescribed displacements [m] at a time [s] (statics: the load factor 0..1) into the
  /// fixed components; empty: they stay 0.
  std::function<void(double time, Out<double> u)> motion;
  DependentNodes dependent;  ///< nodes that follow others, with no component fixed
  /// Writes what is added to the displacements of dependent nodes [m], (dependent nodes, 3), at a time
  /// as that of `motion`: u_i = sum_m w_im u_m + c_i; empty: 0.
  std::function<void(double time, Out<double> offset)> dependent_motion;
  /// Writes additional forces on the nodes [N], (nodes, 3), at a time [s] (statics: the load factor
  /// 0..1); empty: none.
  std::function<void(double time, Out<double> force)> force;
  std::vector<Path> paths;  ///< of both: no step of stages goes across their keys
  /// The voxels whose wind blows in steps of implicit schemes; their nodes are the first ones of the
  /// mesh. Null: none.
  const Scene* in_wind = nullptr;
  std::vector<Collider> colliders;  ///< of time steps; statics ignore them
  ContactPoints contact;            ///< used where there are colliders
  double dt = 1.0 / 60;             ///< [s]
  Scheme scheme = Scheme::kEuler;
  Mass mass_kind = Mass::kLumped;
};

}  // namespace elastogen::fem

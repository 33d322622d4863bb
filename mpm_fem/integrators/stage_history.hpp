// SPDX-License-Identifier: Apache-2.0
// What steps of stages hand on beside the motion of the nodes. Each part may be missing: the next
// step then begins as the first one of a run.

#pragma once

#include "core/array.hpp"
#include "core/ledger.hpp"
#include "core/time_control.hpp"
#include "core/vec3.hpp"

#include <vector>

namespace elastogen::fem {

/// Forces on a piece: their sum [N] and their torque about its centre of mass [N m].
struct Load {
  Vec3 force = {}, torque = {};
};

/// What acts on a piece from outside, but for gravity.
struct PieceLoad {
  Load contact, applied;
  double push = 0;     ///< sum of the sizes of the normal forces of contact [N]
  double closing = 0;  ///< mean speed against the colliders, weighted with these [m/s]
};

/// That of all pieces at one time; empty: not known.
struct Loads {
  std::vector<PieceLoad> pieces;
  std::vector<Vec3> centres;  ///< of mass, which torques are about [m]
  double contact_energy = 0;  ///< of the normal forces [J]
  double bond_energy = 0;     ///< that bonds would hold, where a step ends there [J]
  double rubbed = 0;          ///< power of sliding against friction [W]
  double driven = 0;          ///< power of colliders that move [W]
};

/// What is remembered of a piece.
struct PieceMemory {
  double speed = 0;    ///< the largest one of late, rms, without spin [m/s]
  double spin = 0;     ///< rms speed of the spin about the centre of a free piece [m/s]
  double closing = 0;  ///< the largest one of late [m/s]
  Vec3 struck = {};    ///< change of velocity while it touches, of late [m/s]
  Vec3 turn = {};      ///< about its pins at the start of the last step [rad/s]
};

struct StageHistory {
  double h_before = 0;        ///< length of the step before [s]; 0: there is none
  Array<double> bonds;        ///< slip held by friction (ColliderContact::bonds)
  Loads now, before;          ///< at the ends of the last step and of the one before
  double elastic_energy = 0;  ///< at the end of the last step, where `now` is known [J]
  std::vector<PieceMemory> pieces;
  TimeControl control;
  StepLedger ledger;         ///< of the last step; not known: the next one opens it
  bool in_interval = false;  ///< the last step ended within an interval dt of the scene
};

}  // namespace elastogen::fem

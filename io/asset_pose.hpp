// SPDX-License-Identifier: Apache-2.0
// Up axis and size of an asset: from its file, else a guess with its reason. Every guess that
// rescales or turns anything is reported.

#pragma once

#include "io/asset.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace elastogen {

/// A direction along an axis: sign +1 or -1.
struct UpAxis {
  int axis = 1;
  int sign = 1;
};

/// "x", "y", "z", "-x", "-y" or "-z"; no value for "auto". @throws Error naming them.
std::optional<UpAxis> up_from_name(std::string_view name);
std::string up_name(const UpAxis& up);

/// Why a choice was made.
struct Provenance {
  bool guessed = false;
  std::string reason;  ///< a clause, like "STL states no axis; most are z up"
};

struct UpChoice {
  UpAxis up;
  Provenance from;
};

/// The axis that is asked for, else the one that the file states, else z for STL and LAS (printing,
/// surveying) and y for all others.
UpChoice choose_up(const Asset& asset, const std::optional<UpAxis>& asked);

struct SizeChoice {
  double longest_edge = 0;  ///< [m]
  Provenance from;
  std::string warning;  ///< a sentence if the guess looks wrong: outside 1 mm ... 100 m
};

/// @param longest_edge  of the posed asset [m].
/// @param asked         whether --size was given.
SizeChoice choose_size(const Asset& asset, double longest_edge, bool asked);

/// Scale, then the rotation that turns `up` to y, for the root of a file with y up.
Matrix4 root_matrix(double scale, const UpAxis& up);

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "io/asset_pose.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace elastogen {
namespace {

constexpr const char* kNames[] = {"x", "y", "z", "-x", "-y", "-z"};

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::toupper(c)); });
  return text;
}

}  // namespace

std::optional<UpAxis> up_from_name(std::string_view name) {
  if (name == "auto") return std::nullopt;
  for (int k = 0; k < 6; ++k)
    if (name == kNames[k]) return UpAxis{k % 3, k < 3 ? 1 : -1};
  throw Error(concat("--up '", name, "': known are auto, x, y, z, -x, -y, -z"));
}

std::string up_name(const UpAxis& up) {
  return kNames[up.axis + (up.sign < 0 ? 3 : 0)];
}

UpChoice choose_up(const Asset& asset, const std::optional<UpAxis>& asked) {
  if (asked) return {*asked, {false, "asked for"}};
  const std::string format = upper_case(asset.format);
  if (asset.up != 0)
    return {{std::abs(asset.up) - 1, asset.up > 0 ? 1 : -1}, {false, format + " states it"}};
  if (asset.splats && asset.format == "ply")
    return {{1, 1},
            {true,
             "PLY states no axis; taken as y up, but splats trained on COLMAP cameras have y down: "
             "give --up -y for these"}};
  const bool z = asset.format == "stl" || asset.format == "las";
  return {
      {z ? 2 : 1, 1},
      {true, format + " states no axis; most " + (z ? "such files are z up" : "assets are y up")}};
}

SizeChoice choose_size(const Asset& asset, double longest_edge, bool asked) {
  if (asked) return {longest_edge, {false, "asked for"}, ""};
  const std::string format = upper_case(asset.format);
  if (asset.unit > 0) return {longest_edge, {false, format + " states its unit"}, ""};
  SizeChoice choice = {
      longest_edge, {true, format + " states no unit; its numbers are taken as metres"}, ""};
  if (longest_edge < 1e-3 || longest_edge > 100)
    choice.warning = concat("numbers taken as metres; longest edge ", longest_edge, " m",
                            longest_edge > 100 ? ": millimetres?" : ":", " give --size");
  return choice;
}

Matrix4 root_matrix(double scale, const UpAxis& up) {
  // row of the rotation: from which axis, with which sign, x', y' or z' comes
  struct Row {
    int axis, sign;
  };
  const int s = up.sign;
  const Row turns[3][3] = {{{1, -s}, {0, s}, {2, 1}},   // x up: a quarter turn about z
                           {{0, 1}, {1, s}, {2, s}},    // y up; -y: half a turn about x
                           {{0, 1}, {2, s}, {1, -s}}};  // z up: a quarter turn about x
  Matrix4 m = {};
  for (int row = 0; row < 3; ++row) {
    const Row& from = turns[up.axis][row];
    m[size_t(4 * from.axis + row)] = scale * from.sign;
  }
  m[15] = 1;
  return m;
}

}  // namespace elastogen

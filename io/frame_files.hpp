// SPDX-License-Identifier: Apache-2.0
// What writers of frames share: names of numbered files, the file's own numbers.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// NAME_00012.ending beside path, which is NAME.<any ending>.
std::string frame_path(const std::string& path, int64_t frame, const std::string& ending);

/// The numbered file of a frame of an animation of this name: NAME_00012.ply for NAME.ply, in the
/// same way .obj and .vdb, NAME_00012.vtu for NAME.pvd, the name with its number for a .png that has
/// one; "" for an animation that is a single file.
/// @throws Error (usage) as check_number.
std::string frame_file(const std::string& path, int64_t frame);

/// Whether there is a file of the name itself: all but .ply, .obj, .vdb and numbered
/// .png.
bool has_own_file(const std::string& path);

/// Whether `file` is one of the numbered files of frames 0 ... `frames` of an animation.
bool is_frame_of(const std::string& path, int64_t frames, const std::string& file);

/// What the % of a .png may be: one number of the frame, %d or %04d, in the name of the file.
/// @throws Error (usage) naming the file.
void check_number(const std::string& path);

/// Vertices as the file counts them, which outputs keep, and the carried points.
struct FileOrder {
  std::vector<int32_t> point;   ///< the carried point of each vertex (of its first mesh)
  std::vector<int32_t> vertex;  ///< the vertex of each carried point
  std::vector<Vec3> rest;  ///< of each vertex, in the numbers and axes of the asset: points and
                           ///< splats as the file has them, meshes posed by the node tree
};

FileOrder file_order(const Asset& asset, const Surface& surface);

/// Distance of neighbouring float32 numbers at the largest coordinate.
double float32_step(const std::vector<Vec3>& positions);

/// Whether that is more than 1e-5 of the longest edge: rounded to float32 the shape would be
/// blurred.
bool is_float32_coarse(const std::vector<Vec3>& positions);

/// What every frame must be. @throws Error (usage) for another shape or numbers that are not
/// finite in single precision; where `gradient` is set also for that of F.
void check_frame(const AnimationFrame& frame, int64_t number, int64_t points, bool gradient);

/// Appends the bytes of a value; files are little-endian as the machines that the program runs on.
template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace elastogen

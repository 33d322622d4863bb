// SPDX-License-Identifier: Apache-2.0
// Names of numbered files, and vertices in the file's own order: shared by all writers of frames.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// NAME_00012.ending beside path, which is NAME.<any ending>.
std::string frame_path(const std::string& path, int64_t frame, const std::string& ending);

/// The numbered file of a frame of an animation: NAME_00012.ply for NAME.ply (likewise .obj and
/// .vdb), NAME_00012.vtu for NAME.pvd; for a .png with a number, its name with that number; "" for
/// an animation that is a single file.
/// @throws Error (usage) as check_number.
std::string frame_file(const std::string& path, int64_t frame);

/// Whether a file of exactly this name is written: true except for .ply, .obj, .vdb and numbered
/// .png.
bool has_own_file(const std::string& path);

/// Whether `file` is one of the numbered files of frames 0 ... `frames` of an animation.
bool is_frame_of(const std::string& path, int64_t frames, const std::string& file);

/// Checks the % of a .png: at most one number of the frame, %d or %04d, in the file's name.
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

/// Whether float32_step is more than 1e-5 of the longest edge, so that rounding to float32 would
/// blur the shape.
bool is_float32_coarse(const std::vector<Vec3>& positions);

/// Checks shape and numbers of a frame, those of F too if `gradient` is set. @throws Error (usage)
/// for another shape or a number that is not finite in single precision.
void check_frame(const AnimationFrame& frame, int64_t number, int64_t points, bool gradient);

/// Appends the bytes of a value, little-endian like the machines that the program runs on.
template <class T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace elastogen

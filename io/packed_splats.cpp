// SPDX-License-Identifier: Apache-2.0
#include "io/packed_splats.hpp"

#include "io/splat_ply.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr int64_t kChunkSplats = 256;

/// The lowest bits of a word, shifted, as a share of their range.
double share(uint32_t word, int shift, int bits) {
  const uint32_t range = (1u << bits) - 1;
  return double((word >> shift) & range) / range;
}

/// Largest component (its index in the highest bits, w x y z) from the three others, which are
/// stored in -1/sqrt(2) ... 1/sqrt(2).
std::array<float, 4> rotation_of(uint32_t word) {
  std::array<float, 4> q = {};
  const int largest = int(word >> 30);
  double rest = 1;
  for (int k = 0, shift = 20; k < 4; ++k) {
    if (k == largest) continue;
    const double value = (share(word, shift, 10) - 0.5) * std::sqrt(2.);
    q[size_t(k)] = float(value);
    rest -= value * value;
    shift -= 10;
  }
  q[size_t(largest)] = float(std::sqrt(std::max(rest, 0.)));
  return q;
}

void add_packed(SplatCloud& splats, const SplatChunk& chunk, const std::array<uint32_t, 4>& word) {
  const auto between = [&](int k, double s) {
    return chunk.low[k] + s * (chunk.high[k] - chunk.low[k]);
  };
  const auto [position, rotation, scale, colour] = word;
  splats.position.push_back({between(0, share(position, 21, 11)),
                             between(1, share(position, 11, 10)),
                             between(2, share(position, 0, 11))});
  splats.rotation.push_back(rotation_of(rotation));
  splats.scale.push_back({scale_of_log(float(between(3, share(scale, 21, 11)))),
                          scale_of_log(float(between(4, share(scale, 11, 10)))),
                          scale_of_log(float(between(5, share(scale, 0, 11))))});
  for (int k = 0; k < 3; ++k)
    splats.harmonics.push_back(harmonic_of_colour(between(6 + k, share(colour, 24 - 8 * k, 8))));
  splats.opacity.push_back(float(share(colour, 0, 8)));
}

}  // namespace

bool is_packed(const PlyElement& vertex) {
  return vertex.find({"packed_position"}) >= 0;
}

std::vector<SplatChunk> read_chunks(const PlyElement& element, PlyValues& values,
                                    const std::string& path) {
  // older files have no ranges of colour: the range is 0 to 1
  static constexpr const char* kNames[] = {"x",       "y", "z", "scale_x", "scale_y",
                                           "scale_z", "r", "g", "b"};
  const int ranges = element.find({"min_r"}) >= 0 ? 9 : 6;
  std::vector<size_t> low, high;
  for (int k = 0; k < ranges; ++k) {
    low.push_back(element.number(concat("min_", kNames[k]), path));
    high.push_back(element.number(concat("max_", kNames[k]), path));
  }
  std::vector<SplatChunk> chunks;
  std::vector<double> row;
  for (int64_t i = 0; i < element.count; ++i) {
    values.next_row(element, row);
    SplatChunk& chunk = chunks.emplace_back();
    for (size_t k = 0; k < low.size(); ++k) {
      chunk.low[k] = row[low[k]];
      chunk.high[k] = row[high[k]];
    }
  }
  return chunks;
}

SplatCloud read_packed_splats(const PlyElement& vertex, const std::vector<SplatChunk>& chunks,
                              PlyValues& values, const std::string& path) {
  ELASTOGEN_CHECK_ASSET((vertex.count + kChunkSplats - 1) / kChunkSplats <= int64_t(chunks.size()),
                        path, ": ", vertex.count,
                        " packed splats need a chunk before them for each ", kChunkSplats,
                        ", there are ", chunks.size());
  std::vector<size_t> c;
  for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"})
    c.push_back(vertex.number(name, path));
  SplatCloud splats;
  std::vector<double> row;
  for (int64_t i = 0; i < vertex.count; ++i) {
    values.next_row(vertex, row);
    std::array<uint32_t, 4> word;
    for (size_t k = 0; k < 4; ++k) {
      ELASTOGEN_CHECK_ASSET(row[c[k]] >= 0 && row[c[k]] < 0x1p32, path, ": splat ", i,
                            " has a packed value of ", row[c[k]], ", not of 32 bits");
      word[k] = uint32_t(row[c[k]]);
    }
    add_packed(splats, chunks[size_t(i / kChunkSplats)], word);
  }
  return splats;
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "io/spz_reader.hpp"

#include "io/byte_reader.hpp"
#include "io/gzip_reader.hpp"
#include "io/safe_file.hpp"
#include "io/splat_ply.hpp"

#include <zstd.h>

#include <algorithm>

namespace elastogen {
namespace {

constexpr uint32_t kMagic = 0x5053474e;  ///< the letters "NGSP"
constexpr int64_t kSpzHeaderBytes = 16;
constexpr size_t kHeader4Bytes = 32;  ///< header of version 4, which begins as that of the others
constexpr int64_t kMaxRatio = 100;    ///< of unpacked to packed bytes; splats reach 10

/// 24-bit integer with a sign.
int32_t read_int24(ByteReader& reader) {
  const uint32_t low = reader.read<uint16_t>(), high = reader.read<uint8_t>();
  return int32_t((high << 16 | low) << 8) >> 8;
}

/// Version 2: x y z as bytes; w >= 0 follows from the length one of the quaternion.
std::array<float, 4> read_rotation2(ByteReader& reader) {
  std::array<float, 4> q = {};
  float rest = 1;
  for (size_t k = 1; k < 4; ++k) {
    q[k] = float(reader.read<uint8_t>()) / 127.5f - 1;
    rest -= q[k] * q[k];
  }
  q[0] = std::sqrt(std::max(rest, 0.f));
  return q;
}

/// Version 3: the index of the largest of x y z w in the highest bits, then sign and 9 bits of each
/// of the others, in parts of 1/sqrt(2).
std::array<float, 4> read_rotation3(ByteReader& reader) {
  const uint32_t word = reader.read<uint32_t>();
  const uint32_t largest = word >> 30;
  std::array<float, 4> q = {};
  double rest = 1;
  uint32_t shift = 20;
  for (uint32_t k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const uint32_t bits = word >> shift;
    const double value = (bits & 511) / 511. * std::sqrt(0.5) * (bits & 512 ? -1 : 1);
    q[(k + 1) % 4] = float(value);
    rest -= value * value;
    shift -= 10;
  }
  q[(largest + 1) % 4] = float(std::sqrt(std::max(rest, 0.)));
  return q;
}

struct SpzHeader {
  int64_t splats = 0;
  int version = 0, degree = 0, fraction_bits = 0;
  bool has_extensions = false;

  int64_t splat_bytes() const {
    return 9 + 1 + 3 + 3 + (version == 2 ? 3 : 4) + 3 * (harmonic_count(degree) - 1);
  }
};

/// @param least, most  versions that the file may have.
SpzHeader read_spz_header(const std::string& bytes, uint32_t least, uint32_t most,
                          const std::string& path) {
  ELASTOGEN_CHECK_ASSET(int64_t(bytes.size()) == kSpzHeaderBytes, path, ": has no SPZ header of ",
                        kSpzHeaderBytes, " bytes");
  ByteReader reader(bytes, path);
  ELASTOGEN_CHECK_ASSET(reader.read<uint32_t>() == kMagic, path,
                        ": what it packs is no SPZ; unpack it with gunzip first");
  const uint32_t version = reader.read<uint32_t>();
  ELASTOGEN_CHECK_ASSET(version >= least && version <= most, path, ": SPZ version ", version,
                        " is not read so packed; save it as version 3 or as .ply");
  SpzHeader header;
  header.version = int(version);
  header.splats = reader.read<uint32_t>();
  header.degree = reader.read<uint8_t>();
  header.fraction_bits = reader.read<uint8_t>();
  header.has_extensions = reader.read<uint8_t>() & 2;
  ELASTOGEN_CHECK_ASSET(header.degree <= 3, path, ": harmonics of degree ", header.degree,
                        " are not read; save it with degree 3");
  ELASTOGEN_CHECK_ASSET(header.fraction_bits < 24, path, ": positions of 24 bits cannot have ",
                        header.fraction_bits, " behind the point");
  return header;
}

SplatCloud read_body(const std::string& bytes, const SpzHeader& header, const std::string& path) {
  ByteReader reader(bytes, path);
  const size_t n = size_t(header.splats);
  const size_t width = 3 * size_t(harmonic_count(header.degree));
  SplatCloud splats;
  // all sizes follow from the count of splats
  splats.degree = header.degree;
  splats.position.resize(n);
  splats.opacity.resize(n);
  splats.scale.resize(n);
  splats.rotation.resize(n);
  splats.harmonics.resize(n * width);
  // the streams come one after the other: positions, opacities, first harmonics
  const double unit = std::ldexp(1., -header.fraction_bits);
  for (Vec3& p : splats.position)
    for (double& x : p) x = unit * read_int24(reader);
  for (float& opacity : splats.opacity) opacity = float(reader.read<uint8_t>()) / 255;
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < 3; ++k)
      splats.harmonics[i * width + k] = (float(reader.read<uint8_t>()) / 255 - 0.5f) / 0.15f;
  // then scales, rotations, further harmonics
  for (auto& scale : splats.scale)
    for (float& s : scale) s = scale_of_log(float(reader.read<uint8_t>()) / 16 - 10);
  for (auto& q : splats.rotation)
    q = header.version == 2 ? read_rotation2(reader) : read_rotation3(reader);
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 3; k < width; ++k)
      splats.harmonics[i * width + k] = (float(reader.read<uint8_t>()) - 128) / 128;
  return splats;
}

/// Sizes of the streams of version 4, which hold one attribute each; empty ones are left out.
std::vector<int64_t> stream_sizes(const SpzHeader& header) {
  std::vector<int64_t> sizes;
  for (const int bytes : {9, 1, 3, 3, 4, 3 * (harmonic_count(header.degree) - 1)})
    if (bytes > 0) sizes.push_back(bytes * header.splats);
  return sizes;
}

/// One stream of version 4, in the Zstandard format.
std::string unpacked(std::string_view packed, int64_t size, const std::string& path) {
  std::string out(size_t(size), '\0');
  const size_t done = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
  ELASTOGEN_CHECK_ASSET(!ZSTD_isError(done) && done == out.size(), path,
                        ": a stream of its splats is damaged or has not the ", size,
                        " bytes that they need");
  return out;
}

/// The attributes of version 4. The file has a header of 32 bytes, extensions, a table with packed
/// and unpacked size of each stream, and the streams. Unpacked and joined they are the bytes that
/// version 3 packs as one.
std::string version4_values(std::string_view bytes, const SpzHeader& header,
                            const std::string& path) {
  // the table, as long as the splats need
  ByteReader reader(bytes.substr(15), path);
  const std::vector<int64_t> sizes = stream_sizes(header);
  const size_t streams = reader.read<uint8_t>();
  ELASTOGEN_CHECK_ASSET(streams == sizes.size(), path, ": its splats need ", sizes.size(),
                        " streams, it has ", streams);
  const uint32_t table = reader.read<uint32_t>();
  ELASTOGEN_CHECK_ASSET(table >= kHeader4Bytes && table <= bytes.size(), path,
                        ": its table stands at byte ", table, " of ", bytes.size());
  ByteReader entries(bytes.substr(table), path);
  entries.claim(int64_t(streams), 16, "streams");
  std::string_view rest = bytes.substr(table + 16 * streams);
  std::string values;
  // unpack stream after stream, no more than the table and the splats allow
  for (const int64_t size : sizes) {
    const uint64_t from = entries.read<uint64_t>(), to = entries.read<uint64_t>();
    ELASTOGEN_CHECK_ASSET(from <= rest.size() && to == uint64_t(size), path, ": a stream of ", from,
                          " bytes unpacks to ", to, "; ", rest.size(), " are left, ", size,
                          " are needed");
    values += unpacked(rest.substr(0, size_t(from)), size, path);
    rest.remove_prefix(size_t(from));
  }
  ELASTOGEN_CHECK_ASSET(rest.empty(), path, ": ", rest.size(), " bytes follow its streams");
  return values;
}

void check_claim(const SpzHeader& header, std::string_view bytes, const std::string& path) {
  const int64_t body = header.splats * header.splat_bytes();
  ELASTOGEN_CHECK_ASSET(body <= std::min(kMaxRatio * int64_t(bytes.size()), kMaxFileBytes), path,
                        ": claims ", header.splats, " splats of ", header.splat_bytes(),
                        " bytes, too many for a file of ", bytes.size(), " bytes");
}

/// The attributes that gzip packs.
std::string gzip_values(GzipReader& unpacker, const SpzHeader& header, const std::string& path) {
  const int64_t body = header.splats * header.splat_bytes();
  const std::string values = unpacker.next(body);
  ELASTOGEN_CHECK_ASSET(int64_t(values.size()) == body, path, ": its ", header.splats,
                        " splats need ", body, " bytes, it unpacks to ", values.size());

  // reaching the end of the stream checks its sum; files with extensions are not read so far
  ELASTOGEN_CHECK_ASSET(header.has_extensions || unpacker.next(1).empty(), path,
                        ": unpacks to more bytes than its ", header.splats, " splats");
  return values;
}

}  // namespace

Asset parse_spz(std::string_view bytes, const std::string& path) {
  Asset asset;
  asset.path = path;
  asset.format = "spz";
  if (bytes.starts_with("NGSP")) {
    ELASTOGEN_CHECK_ASSET(bytes.size() >= kHeader4Bytes, path, ": has no SPZ header of ",
                          kHeader4Bytes, " bytes");
    const SpzHeader header =
        read_spz_header(std::string(bytes.substr(0, kSpzHeaderBytes)), 4, 4, path);
    check_claim(header, bytes, path);
    asset.splats = read_body(version4_values(bytes, header, path), header, path);
    return asset;
  }
  GzipReader unpacker(bytes, path);
  const SpzHeader header = read_spz_header(unpacker.next(kSpzHeaderBytes), 2, 3, path);
  check_claim(header, bytes, path);
  asset.splats = read_body(gzip_values(unpacker, header, path), header, path);
  return asset;
}

Asset read_spz(const std::string& path) {
  return parse_spz(read_file(path), path);
}

}  // namespace elastogen

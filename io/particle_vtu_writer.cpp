// SPDX-License-Identifier: Apache-2.0
#include "io/particle_vtu_writer.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"
#include "io/vtu_file.hpp"

#include <numeric>

namespace elastogen {
namespace {

constexpr uint8_t kVertex = 1;

class ParticleVtuWriter : public AnimationWriter {
 public:
  ParticleVtuWriter(const std::string& path, const AnimationOptions& options)
      : path_(path), frames_(path) {
    ELASTOGEN_CHECK(options.scene && options.particles, path, ": particles need their scene");
    place_ = options.scene->place;
    particles_ = *options.particles;
  }

  bool needs_motion() const override { return true; }

  void frame(const AnimationFrame& frame) override {
    const int64_t count = particles_.count();
    ELASTOGEN_CHECK(frame.state && frame.particles && frame.state->x.rows() == count, path_,
                    ": a frame must come with the state and the strain of ", count, " particles");
    VtuFile file;
    file.section(concat("<UnstructuredGrid>\n<Piece NumberOfPoints=\"", count,
                        "\" NumberOfCells=\"", count, "\">\n"));
    file.points(frame.state->x.data(), count, place_);
    file.section("<PointData>\n");
    file.floats("velocity", frame.state->v.data(), 3 * count, 3);
    add_strain(*frame.particles, file);
    add_material(file);
    file.section("</PointData>\n");
    add_cells(file);
    file.section("</Piece>\n</UnstructuredGrid>\n");
    frames_.add(file, frame.state->time);
  }

  void finish() override { frames_.finish(); }

 private:
  void add_strain(const ParticleStrain& strain, VtuFile& file) const {
    const int64_t count = particles_.count();
    std::vector<float> J;
    for (int64_t p = 0; p < count; ++p)
      J.push_back(float(determinant(load_matrix(strain.F.row(p)))));
    file.floats("F", strain.F.data, 9 * count, 9);
    file.array("J", "Float32", J);
    file.floats("memory", strain.memory.data, count);
    file.floats("kirchhoff_stress", strain.stress.data, 6 * count, 6);
  }

  void add_material(VtuFile& file) const {
    const int64_t count = particles_.count();
    file.floats("mass", particles_.mass.data, count);
    file.floats("volume", particles_.volume.data, count);
    const int32_t* material = particles_.material.data;
    file.array("material", "Int32", std::vector<int32_t>(material, material + count));
  }

  /// One vertex cell for each particle; without cells ParaView shows nothing.
  void add_cells(VtuFile& file) const {
    std::vector<int32_t> point(size_t(particles_.count()));
    std::vector<int64_t> end(point.size());
    std::iota(point.begin(), point.end(), 0);
    std::iota(end.begin(), end.end(), 1);
    file.section("<Cells>\n");
    file.array("connectivity", "Int32", point);
    file.array("offsets", "Int64", end);
    file.array("types", "UInt8", std::vector<uint8_t>(point.size(), kVertex));
    file.section("</Cells>\n");
  }

  std::string path_;
  PvdFrames frames_;
  Vec3 place_ = {};
  ParticleSet particles_;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_particle_vtu_writer(const std::string& path,
                                                          const AnimationOptions& options) {
  return std::make_unique<ParticleVtuWriter>(path, options);
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "io/vtu_writer.hpp"

#include "core/elastic_law.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/principal.hpp"
#include "core/vec3.hpp"
#include "io/voxel_corners.hpp"
#include "io/vtu_file.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace elastogen {
namespace {

/// Deformation gradient at the centroid of a tetrahedron. There the shape function 4 l_i l_j of an
/// edge's middle has the slope of l_i + l_j, and the corners of quadratic tetrahedra have the slope
/// zero. So the sum of the three middles beside a corner stands for that corner.
Mat3<double> centroid_gradient(const int32_t* node, int64_t nodes, const Array<double>& rest,
                               const Array<double>& x) {
  constexpr int kMiddles[4][3] = {{4, 6, 7}, {4, 5, 8}, {5, 6, 9}, {7, 8, 9}};
  Vec3 X[4] = {}, now[4] = {};
  for (size_t c = 0; c < 4; ++c)
    for (size_t k = 0; k < (nodes == 4 ? 1 : 3); ++k) {
      const int32_t n = nodes == 4 ? node[c] : node[kMiddles[c][k]];
      X[c] = plus(X[c], {rest(n, 0), rest(n, 1), rest(n, 2)});
      now[c] = plus(now[c], {x(n, 0), x(n, 1), x(n, 2)});
    }
  const Vec3 a = minus(X[1], X[0]), b = minus(X[2], X[0]), c = minus(X[3], X[0]);
  const Vec3 slope[3] = {cross(b, c), cross(c, a), cross(a, b)};  // times the volume
  const double volume = dot(a, slope[0]);
  Mat3<double> F = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k)
        F(i, j) += (now[k + 1][size_t(i)] - now[0][size_t(i)]) * slope[k][size_t(j)] / volume;
  return F;
}

/// sigma = P F^T / J = U diag(t_k s_k / J) U^T, as xx yy zz xy yz xz.
void cauchy_stress(const Material& material, const Mat3<double>& F, float* result) {
  const Svd3<double> svd = svd3(F);
  const double* s = svd.sigma;
  const double J = s[0] * s[1] * s[2];
  const Response<double> r =
      elastic_response<false>({material.law, material.mu(), material.lambda()}, s);
  constexpr int kRow[6] = {0, 1, 2, 0, 1, 0}, kColumn[6] = {0, 1, 2, 1, 2, 2};
  for (int c = 0; c < 6; ++c) {
    double sum = 0;
    for (int k = 0; k < 3; ++k)
      sum += svd.U(kRow[c], k) * svd.U(kColumn[c], k) * (r.t[k] * s[k] / J);
    result[c] = J > 0 ? float(sum) : std::numeric_limits<float>::quiet_NaN();
  }
}

class VtuWriter : public AnimationWriter {
 public:
  VtuWriter(const std::string& path, const AnimationOptions& options)
      : path_(path), frames_(path), scene_(options.scene), tets_(options.tets) {
    ELASTOGEN_CHECK(scene_, path, ": voxel data need a scene");
    if (!tets_) corners_.emplace(scene_->grid);
  }

  bool needs_motion() const override { return true; }

  void frame(const AnimationFrame& frame) override {
    const VoxelGrid& grid = scene_->grid;
    ELASTOGEN_CHECK(frame.state && Span<const double>(frame.state->x).is(grid.node_count(), 3),
                    path_, ": a frame must come with the state of the scene");
    VtuFile file;
    file.section(concat("<UnstructuredGrid>\n<Piece NumberOfPoints=\"", grid.node_count(),
                        "\" NumberOfCells=\"", cell_count(), "\">\n"));
    const Array<double> u = displacement(frame.state->x);
    add_points(frame, u, file);
    add_cells(file);
    add_strain(frame.state->x, u, file);
    file.section("</Piece>\n</UnstructuredGrid>\n");
    frames_.add(file, frame.state->time);
  }

  void finish() override { frames_.finish(); }

 private:
  int64_t cell_count() const { return tets_ ? tets_->rows() : scene_->grid.voxel_count(); }

  Mat3<double> gradient(int64_t cell, const Array<double>& x, const Array<double>& u) const {
    if (tets_) return centroid_gradient(tets_->row(cell), tets_->cols(), scene_->grid.rest, x);
    Mat3<double> F = mean_slope(scene_->grid, cell, u);
    for (int d = 0; d < 3; ++d) F(d, d) += 1;
    return F;
  }

  /// Displacement of the nodes [m].
  Array<double> displacement(const Array<double>& x) const {
    Array<double> u = x;
    for (int64_t k = 0; k < u.size(); ++k) u.data()[k] -= scene_->grid.rest.data()[k];
    return u;
  }

  /// A nodal field as it is drawn: voxels carry the corners that the body hardly fills.
  Array<double> drawn(const Array<double>& field) const {
    return corners_ ? corners_->drawn(field) : field;
  }

  void add_points(const AnimationFrame& frame, const Array<double>& u, VtuFile& file) const {
    const State& state = *frame.state;
    const int64_t size = state.x.size();
    const Array<double> shown = drawn(u);
    Array<double> x = shown;
    for (int64_t k = 0; k < size; ++k) x.data()[k] += scene_->grid.rest.data()[k];
    file.points(x.data(), x.rows(), scene_->place);
    file.section("<PointData>\n");
    file.floats("displacement", shown.data(), size, 3);
    if (state.v.size() == size) file.floats("velocity", drawn(state.v).data(), size, 3);
    if (frame.residual.size() == size) file.floats("residual", frame.residual.data, size, 3);
    file.section("</PointData>\n");
  }

  void add_cells(VtuFile& file) const {
    constexpr int kOrder[8] = {0, 1, 3, 2, 4, 5, 7, 6};  // VTK: around the lower face, the upper
    constexpr uint8_t kHexahedron = 12, kTetrahedron = 10, kQuadraticTetrahedron = 24;
    const Array<int32_t>& cells = tets_ ? *tets_ : scene_->grid.corners;
    const uint8_t type = !tets_              ? kHexahedron
                         : cells.cols() == 4 ? kTetrahedron
                                             : kQuadraticTetrahedron;
    std::vector<int32_t> corners;
    std::vector<int64_t> ends;
    for (int64_t v = 0; v < cells.rows(); ++v) {
      for (int c = 0; c < cells.cols(); ++c) corners.push_back(cells(v, tets_ ? c : kOrder[c]));
      ends.push_back(cells.cols() * (v + 1));
    }
    file.section("<Cells>\n");
    file.array("connectivity", "Int32", corners);
    file.array("offsets", "Int64", ends);
    file.array("types", "UInt8", std::vector<uint8_t>(ends.size(), type));
    file.section("</Cells>\n");
  }

  void add_strain(const Array<double>& x, const Array<double>& u, VtuFile& file) const {
    const auto cells = size_t(cell_count());
    std::vector<float> gradients(9 * cells), stress(6 * cells), J(cells);
    for_each(cell_count(), [&](int64_t v) {
      const Mat3<double> F = gradient(v, x, u);
      std::copy(F.m, F.m + 9, gradients.begin() + 9 * v);
      J[size_t(v)] = float(determinant(F));
      cauchy_stress(scene_->materials[size_t(scene_->material(v))], F, stress.data() + 6 * v);
    });
    const int32_t* material = scene_->material.data();
    file.section("<CellData>\n");
    file.array("F", "Float32", gradients, 9);
    file.array("J", "Float32", J);
    file.array("cauchy_stress", "Float32", stress, 6);
    if (!tets_) file.floats("fill", scene_->grid.fill.data(), cell_count());
    file.array("material", "Int32",
               std::vector<int32_t>(material, material + scene_->material.size()));
    file.section("</CellData>\n");
  }

  std::string path_;
  PvdFrames frames_;
  const Scene* scene_;
  const Array<int32_t>* tets_;
  std::optional<VoxelCorners> corners_;  ///< for voxels
};

}  // namespace

std::unique_ptr<AnimationWriter> make_vtu_writer(const std::string& path,
                                                 const AnimationOptions& options) {
  return std::make_unique<VtuWriter>(path, options);
}

}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/dependent_tet_nodes.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/levelled_tet_distance.hpp"
#include "voxelize/sloped_nodes.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace elastogen::fem {
namespace {

constexpr double kAhead = 0.2;   // least cosine of the angle between a way ahead and the normal
constexpr double kAlong = 1e-3;  // weight of offsets along the normal, of quadratic elements
constexpr double kSmallFactors = 1e-8;  // weight of what keeps factors small

/// A node ahead: t and its distance from the border, both over h.
struct Ahead {
  int32_t node;
  Eigen::Vector3d offset;
  double distance;
};

/// alpha of some nodes, by the conditions at its extremum: alpha_m = d_m^2 (nu - t_m.y), with y the sum
/// of alpha_m t_m over epsilon.
Eigen::VectorXd extremum(const std::vector<Ahead>& ahead) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  for (const Ahead& m : ahead) {
    Eigen::Vector4d row;
    row << 1, -m.offset;
    A += m.distance * m.distance * row * row.transpose();
  }
  A.bottomRightCorner<3, 3>() += kSmallFactors * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d solution = A.ldlt().solve(Eigen::Vector4d(1, 0, 0, 0));
  Eigen::VectorXd alpha(Eigen::Index(ahead.size()));
  for (size_t m = 0; m < ahead.size(); ++m)
    alpha[Eigen::Index(m)] = ahead[m].distance * ahead[m].distance *
                             (solution[0] - ahead[m].offset.dot(solution.tail<3>()));
  return alpha;
}

/// The same with alpha >= 0 where that is asked for: the nodes with the most negative ones leave, one by
/// one.
Eigen::VectorXd weights_of(bool positive, std::vector<Ahead>& ahead) {
  while (true) {
    Eigen::VectorXd alpha = extremum(ahead);
    Eigen::Index worst = 0;
    if (!positive || ahead.size() == 1 || alpha.minCoeff(&worst) >= 0) return alpha / alpha.sum();
    ahead.erase(ahead.begin() + worst);
  }
}

class Follow {
 public:
  Follow(const ElementMesh& mesh, const std::vector<Border>& borders,
         const std::vector<BorderElement>& cut, const Array<uint8_t>& pinned)
      : mesh_(mesh), borders_(borders), pinned_(pinned) {
    std::vector<std::vector<int32_t>> elements(borders.size());
    for (const BorderElement& at : cut) elements[size_t(at.border)].push_back(at.element);
    for (size_t b = 0; b < borders.size(); ++b)
      distance_.emplace_back(mesh, borders[b], elements[b]);
    std::map<int32_t, std::pair<double, int>> spacings;
    for (const BorderElement& at : cut)
      for (int a = 0; a < mesh.elements.cols(); ++a) {
        const int32_t node = mesh.elements(at.element, a);
        auto& [sum, count] = spacings[node];
        sum += spacing_of(at.element), ++count;
        consider(node, at.border);
      }
    for (const auto& [node, sum] : spacings) spacing_[node] = sum.first / sum.second;
    std::erase_if(followers_, [&](const auto& entry) {
      return entry.second.distance >= nearest(entry.first, entry.second.border);
    });
    find_neighbours();
  }

  std::vector<int32_t> borders_of_nodes() const { return borders_of(followers_); }

  DependentNodes build() {
    return follow_slopes(followers_, [&](int32_t node, SlopedNode& of) { find_slope(node, of); });
  }

 private:
  Vec3 rest(int32_t node) const {
    return {mesh_.rest(node, 0), mesh_.rest(node, 1), mesh_.rest(node, 2)};
  }

  double weight_along() const { return mesh_.elements.cols() == 10 ? kAlong : 0; }

  /// Mean distance of neighbouring nodes of an element.
  double spacing_of(int32_t element) const {
    double sum = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        sum += norm(minus(rest(mesh_.elements(element, a)), rest(mesh_.elements(element, b))));
    return sum / (mesh_.elements.cols() == 4 ? 6 : 12);
  }

  double nearest(int32_t node, int32_t border) const {
    return nearest_free(borders_[size_t(border)]) * spacing_.at(node);
  }

  /// Gives a node of a cut element to the nearest border.
  void consider(int32_t node, int32_t border) {
    if (pinned_(node)) return;
    offer(followers_, node, border, distance_[size_t(border)](node));
  }

  void find_neighbours() {
    for (int64_t e = 0; e < mesh_.elements.rows(); ++e)
      for (int a = 0; a < mesh_.elements.cols(); ++a) {
        if (!followers_.contains(mesh_.elements(e, a))) continue;
        std::set<int32_t>& around = neighbours_[mesh_.elements(e, a)];
        around.insert(mesh_.elements.row(e), mesh_.elements.row(e) + mesh_.elements.cols());
      }
  }

  /// Distance of a node whose slope another one may take from the border, 0: of none.
  double distance_ahead(int32_t node, const SlopedNode& of) const {
    if (pinned_(node)) return 0;
    if (const auto other = followers_.find(node); other != followers_.end()) {
      const SlopedNode& ahead = other->second;
      if (!ahead.known || ahead.border != of.border || ahead.slope.empty()) return 0;
      // it stands for its parent nodes
      double inverse = 0;
      for (const auto& [parent, factor] : ahead.slope) inverse += std::abs(factor);
      return 1 / inverse;
    }
    const double d = distance_[size_t(of.border)](node);
    const double spacing = spacing_.contains(node) ? spacing_.at(node) : 0;
    return d < nearest_free(borders_[size_t(of.border)]) * spacing ? 0 : d;
  }

  void find_slope(int32_t node, SlopedNode& of) {
    of.known = true;
    const Vec3 X = rest(node), n = distance_gradient(borders_[size_t(of.border)], X);
    const double h = spacing_.at(node);
    // the nodes ahead
    std::vector<Ahead> ahead;
    for (const int32_t m : neighbours_.at(node)) {
      const Vec3 way = minus(rest(m), X);
      const double along = dot(way, n);
      if (m == node || along < kAhead * norm(way)) continue;
      const double d = distance_ahead(m, of);
      if (!(d > 0)) continue;
      const Vec3 t = scaled(minus(way, scaled(n, along * (1 - weight_along()))), 1 / h);
      ahead.push_back({m, {t[0], t[1], t[2]}, d / h});
    }
    if (ahead.empty()) return;
    // their slopes
    const Eigen::VectorXd alpha = weights_of(weight_along() == 0, ahead);
    for (size_t k = 0; k < ahead.size(); ++k) {
      const double weight = alpha[Eigen::Index(k)];
      const auto other = followers_.find(ahead[k].node);
      if (other == followers_.end())
        of.slope[ahead[k].node] += weight / (ahead[k].distance * h);
      else
        for (const auto& [parent, factor] : other->second.slope)
          of.slope[parent] += weight * factor;
    }
  }

  const ElementMesh& mesh_;
  const std::vector<Border>& borders_;
  const Array<uint8_t>& pinned_;
  std::vector<LevelledTetDistance> distance_;
  std::map<int32_t, double> spacing_;  // of nodes of cut elements
  SlopedNodes followers_;
  std::map<int32_t, std::set<int32_t>> neighbours_;  // of dependent nodes
};

}  // namespace

DependentNodes dependent_tet_nodes(const ElementMesh& mesh, const std::vector<Border>& borders,
                                   const std::vector<BorderElement>& cut,
                                   const Array<uint8_t>& pinned,
                                   std::vector<int32_t>* borders_of_nodes) {
  if (cut.empty()) return {};
  Follow follow(mesh, borders, cut, pinned);
  if (borders_of_nodes) *borders_of_nodes = follow.borders_of_nodes();
  return follow.build();
}

}  // namespace elastogen::fem

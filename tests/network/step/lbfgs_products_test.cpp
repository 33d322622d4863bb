// SPDX-License-Identifier: Apache-2.0
#include "network/step/lbfgs_products.hpp"

#include "network/step/lbfgs.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <numeric>
#include <random>

namespace elastogen::test {
namespace {

constexpr int64_t kPairSize = 40;
using Vector = std::vector<double>;

/// A gradient along a walk through a quadratic with a little noise, as an iteration sees it.
struct Walk {
  std::mt19937 random{7};
  Vector x = Vector(kPairSize), g = Vector(kPairSize);

  void gradient_at(const Vector& at, Vector& result) const {
    for (size_t i = 0; i < size_t(kPairSize); ++i)
      result[i] = (1 + double(i)) * at[i] + 0.3 * at[(i + 1) % size_t(kPairSize)] +
                  0.3 * at[(i + size_t(kPairSize) - 1) % size_t(kPairSize)] + std::sin(double(i));
  }
  /// Moves by a random step; gives s and y.
  void move(Vector& s, Vector& y) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    s.resize(size_t(kPairSize));
    for (size_t i = 0; i < s.size(); ++i) s[i] = uniform(random), x[i] += s[i];
    const Vector before = g;
    gradient_at(x, g);
    y = g;
    for (size_t i = 0; i < y.size(); ++i) y[i] -= before[i];
  }
};

double product(const Vector& a, const Vector& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// The pairs of a history, the newest first, and their products.
struct History {
  LbfgsProducts products;
  std::deque<Vector> s, y;

  bool take(const Vector& new_s, const Vector& new_y, const Vector& g) {
    LbfgsProducts::Newest newest = {product(new_s, new_y),
                                    product(new_s, new_s),
                                    product(new_y, new_y),
                                    product(new_s, g),
                                    {},
                                    {}};
    const int older = products.older();
    s.resize(size_t(older)), y.resize(size_t(older));
    for (int k = 0; k < older; ++k) {
      newest.older_g[k] = product(s[size_t(k)], g);
      newest.older_y[k] = product(s[size_t(k)], new_y);
    }
    if (!products.take(newest)) return false;
    s.push_front(new_s), y.push_front(new_y);
    return true;
  }

  /// H g with the first matrix 1/(1 + i).
  Vector direction(const Vector& g) const {
    double alpha[LbfgsProducts::kPairs], yd[LbfgsProducts::kPairs] = {}, c[LbfgsProducts::kPairs];
    products.first_loop(alpha);
    Vector d = g;
    for (size_t k = 0; k < s.size(); ++k) add_scaled(-alpha[k], y[k].data(), d.data(), kPairSize);
    for (size_t i = 0; i < d.size(); ++i) d[i] /= 1 + double(i);
    for (size_t k = 0; k < s.size(); ++k) yd[k] = product(y[k], d);
    products.second_loop(alpha, yd, c);
    for (size_t k = 0; k < s.size(); ++k) add_scaled(c[k], s[k].data(), d.data(), kPairSize);
    return d;
  }
};

Vector reference_direction(const Lbfgs<double>& lbfgs, const Vector& g) {
  Vector q(g.size()), d(g.size());
  lbfgs.direction(g.data(), q.data(), d.data(), [](const double* from, double* to) {
    for (size_t i = 0; i < size_t(kPairSize); ++i) to[i] = from[i] / (1 + double(i));
  });
  return d;
}

TEST(LbfgsProducts, GiveTheDirectionOfTheTwoLoops) {
  Walk walk;
  walk.gradient_at(walk.x, walk.g);
  Lbfgs<double> lbfgs(kPairSize);
  History history;
  for (int step = 0; step < 12; ++step) {
    const Vector expected = reference_direction(lbfgs, walk.g), d = history.direction(walk.g);
    for (size_t i = 0; i < d.size(); ++i) EXPECT_NEAR(d[i], expected[i], 1e-10) << "step " << step;
    Vector s, y;
    walk.move(s, y);
    const bool refused = step == 3 || step == 8;  // of a short and of a full history
    if (refused)
      for (double& value : y) value = -value;
    std::copy(s.begin(), s.end(), lbfgs.next_s());
    std::copy(y.begin(), y.end(), lbfgs.next_y());
    ASSERT_EQ(lbfgs.keep(), !refused);
    ASSERT_EQ(history.take(s, y, walk.g), !refused);
    EXPECT_EQ(history.products.count, lbfgs.count());
  }
}

TEST(LbfgsProducts, LeaveOutAPairWithoutCurvature) {
  Walk walk;
  walk.gradient_at(walk.x, walk.g);
  History history;
  Vector s, y;
  for (int step = 0; step < 7; ++step) walk.move(s, y), history.take(s, y, walk.g);
  walk.move(s, y);
  Vector turned = y;
  for (double& value : turned) value = -value;
  EXPECT_FALSE(history.take(s, turned, walk.g));
  EXPECT_EQ(history.products.count, LbfgsProducts::kOlder);  // the oldest pair was overwritten
  // the four pairs that are left satisfy the newest secant equation: H y = s
  LbfgsProducts& products = history.products;
  for (size_t k = 0; k < history.s.size(); ++k)
    products.sg[k] = product(history.s[k], history.y[0]);
  const Vector found = history.direction(history.y[0]);
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], history.s[0][i], 1e-10);
}

}  // namespace
}  // namespace elastogen::test

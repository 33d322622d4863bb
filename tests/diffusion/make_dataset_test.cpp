// SPDX-License-Identifier: Apache-2.0
#include "diffusion/make_dataset.hpp"

#include "core/error.hpp"
#include "diffusion/material_family.hpp"
#include "diffusion/material_features.hpp"
#include "io/safe_file.hpp"
#include "tests/diffusion/dataset.hpp"
#include "training/last_layer_fit.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace elastogen {
namespace {

MakeDatasetOptions few() {
  MakeDatasetOptions options;
  options.count = 7;
  options.seed = 3;
  options.iterations = 12;
  options.strains = 64;
  options.judged = 64;
  return options;
}

TEST(TreeOrder, AddsWhatIsNearestToTheTree) {
  // on a line beside the root: 5 0 1 3, nearest first
  const std::vector<double> root = material_features(fit_material("hencky", 0.3));
  Array<double> features(4, kMaterialFeatures);
  const double places[] = {5, 0.5, 1, 3};
  for (int64_t n = 0; n < 4; ++n) {
    std::copy(root.begin(), root.end(), features.row(n));
    features(n, 8) += places[n];
  }
  const TreeOrder tree = tree_order(features);
  EXPECT_EQ(tree.order, (std::vector<int64_t>{1, 2, 3, 0}));
  EXPECT_EQ(tree.parent, (std::vector<int64_t>{-1, 1, 2, 3}));
}

TEST(TreeOrder, HasTheLeastSumOfDistancesToParents) {
  const WeightDataset data = test::some_dataset(60);
  const TreeOrder tree = tree_order(data.features);
  std::vector<bool> there(60);
  for (size_t k = 0; k < 60; ++k) {
    const auto d = [&](int64_t a, int64_t b) {
      return feature_distance(data.features.row(a), data.features.row(b));
    };
    const int64_t n = tree.order[k], parent = tree.parent[k];
    if (k > 0) {  // no edge out of the tree is shorter
      EXPECT_TRUE(there[size_t(parent)]);
      for (int64_t a = 0; a < 60; ++a)
        for (int64_t b = 0; b < 60; ++b)
          if (there[size_t(a)] && !there[size_t(b)]) {
            EXPECT_GE(d(a, b), d(n, parent));
          }
    }
    EXPECT_FALSE(there[size_t(n)]);
    there[size_t(n)] = true;
  }
}

TEST(NearestRows, AreSortedByDistance) {
  const WeightDataset data = test::some_dataset(20);
  const double* const x = data.features.row(4);
  const std::vector<int64_t> all = nearest_rows(data.features, x, 50, 4);
  ASSERT_EQ(all.size(), 19u);
  for (size_t k = 1; k < all.size(); ++k)
    EXPECT_LE(feature_distance(data.features.row(all[k - 1]), x),
              feature_distance(data.features.row(all[k]), x));
  EXPECT_EQ(std::count(all.begin(), all.end(), 4), 0);
  EXPECT_EQ(nearest_rows(data.features, x, 1), (std::vector<int64_t>{4}));
}

TEST(MakeDataset, FitsTheMaterialsOfTheFamilyAndStatesTheirErrors) {
  const std::vector<float> hidden = test::some_hidden();
  const MadeDataset made = make_dataset(hidden, few());
  ASSERT_EQ(made.data.count(), 7);
  EXPECT_EQ(made.fits, 7);
  for (int64_t n = 0; n < 7; ++n) {
    const FitMaterial& material = made.data.materials[size_t(n)];
    EXPECT_EQ(material.name, family_material(3, uint64_t(n)).name);
    ReportOptions judged;
    judged.strains = 64;
    const FitReport report = fit_report(material, made.data.weights(n), judged);
    EXPECT_EQ(made.data.errors(n, 0), report.stress_median);
    EXPECT_EQ(made.data.errors(n, 1), report.stress_p99);
    EXPECT_EQ(made.data.errors(n, 2), report.stress_max);
    EXPECT_EQ(made.data.errors(n, 3), report.tangent_p99);
    EXPECT_EQ(made.data.passes(n), report.passes());
    // no worse than from zero with twelve iterations, apart from the rounding to floats
    EXPECT_LT(made.data.rms[size_t(n)], 1);
    EXPECT_GT(made.data.iterations[size_t(n)], 0);
  }
}

TEST(MakeDataset, GoesOnFromItsCheckpointWithTheSameBits) {
  const auto folder = std::filesystem::temp_directory_path() / "elastogen-make-dataset";
  std::filesystem::create_directories(folder);
  const std::vector<float> hidden = test::some_hidden();
  MakeDatasetOptions options = few();
  const std::string whole = encode_dataset(make_dataset(hidden, options).data);
  options.checkpoint = (folder / "a.h5.part").string();
  options.checkpoint_fits = 2;
  int asked = 0;
  FitHooks hooks;
  hooks.stopped = [&] { return ++asked > 3; };
  const MadeDataset part = make_dataset(hidden, options, hooks);
  EXPECT_EQ(part.data.count(), 0);
  EXPECT_EQ(part.fits, 3);
  options.resume = true;
  std::string said;
  hooks.stopped = [] { return false; };
  hooks.say = [&](const std::string& line) { said += line + '\n'; };
  EXPECT_EQ(encode_dataset(make_dataset(hidden, options, hooks).data), whole);
  EXPECT_NE(said.find("resumed after 3 fits"), std::string::npos) << said;
  // a checkpoint of others is refused
  options.seed = 4;
  EXPECT_THROW(make_dataset(hidden, options), Error);
  options.seed = 3;
  std::vector<float> other = hidden;
  other[0] += 1;
  EXPECT_THROW(make_dataset(other, options), Error);
  write_file(options.checkpoint, "elastogen-weight-dataset 1\nno more");
  EXPECT_THROW(make_dataset(hidden, options), Error);
  std::filesystem::remove_all(folder);
}

TEST(MakeDataset, RejectsCountsThatAreNotPositive) {
  MakeDatasetOptions options = few();
  options.count = 0;
  EXPECT_THROW(make_dataset(test::some_hidden(), options), Error);
  EXPECT_THROW(make_dataset(std::vector<float>(4), few()), Error);
}

}  // namespace
}  // namespace elastogen

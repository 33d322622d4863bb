// SPDX-License-Identifier: Apache-2.0
// Weight files: the claims of a fit are checked, files that do not fit are refused with a sentence.

#include "network/law/mtl_weights.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

TensorFile sample() {
  TensorFile file;
  file.text = {{"form", kMtlForm},
               {"law", "hencky"},
               {"poisson", "0.3"},
               {"error.stress.median", "1e-4"},
               {"error.stress.p99", "1e-3"},
               {"error.stress.max", "0.01"},
               {"error.tangent.p99", "0.002"}};
  file.tensors.push_back({"neural_mtl",
                          {NeuralMtl::kParameters},
                          std::vector<float>(size_t(NeuralMtl::kParameters), 0.0f)});
  return file;
}

std::string refusal(const TensorFile& file) {
  try {
    read_weights(encode_tensors(file), "a.weights", Law::kHencky, 0.3, Evaluation::kNet);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    return error.what();
  }
  return "not refused";
}

void expect_words(const TensorFile& file, const std::string& words) {
  EXPECT_NE(refusal(file).find(words), std::string::npos) << refusal(file);
}

TEST(MtlWeights, ReadsItsFileAndNamesItByItsHash) {
  const std::string bytes = encode_tensors(sample());
  const auto law = read_weights(bytes, "a", Law::kHencky, 0.3, Evaluation::kNet);
  EXPECT_EQ(law->law(), Law::kHencky);
  EXPECT_EQ(law->poisson(), 0.3);
  EXPECT_EQ(law->hash(), hex(sha256(bytes)));
  EXPECT_EQ(weight_file_name(Law::kNeoHookean, 0.45), "neo-hookean-0.45.weights");
  EXPECT_EQ(weight_file_name(Law::kStvk, 0), "stvk-0.weights");
}

TEST(MtlWeights, RefusesWhatIsOfAnotherMaterialOrNotGoodEnough) {
  TensorFile file = sample();
  file.text["law"] = "stvk";
  expect_words(file, "not the weights of hencky");
  file = sample();
  file.text["form"] = "log stretches";
  expect_words(file, "another form of NeuralMTL");
  file = sample();
  file.text["poisson"] = "0.31";
  expect_words(file, "Poisson ratio 0.31");
  file = sample();
  file.text["error.stress.max"] = "0.03";
  expect_words(file, "not good enough");
  file.text["error.stress.max"] = "nan";
  expect_words(file, "not good enough");
  file.text["error.stress.max"] = "small";
  expect_words(file, "no number");
  file.text.erase("error.stress.max");
  expect_words(file, "has no 'error.stress.max'");
  file = sample();
  file.tensors[0].shape = {NeuralMtl::kParameters - 1};
  file.tensors[0].values.pop_back();
  expect_words(file, "not the shape");
}

// zeroed weights are the Hencky law, and in the place of another they are caught
TEST(MtlWeights, FitErrorsTellAGoodFitFromABadOne) {
  const std::vector<float> zero(size_t(NeuralMtl::kParameters), 0.0f);
  for (const Evaluation evaluation : {Evaluation::kNet, Evaluation::kTable}) {
    const FitErrors good = fit_errors({zero, Law::kHencky, 0.4, "", evaluation}, 4000);
    EXPECT_LT(good.stress_max, 1e-9);
    EXPECT_LT(good.tangent_p99, 1e-9);
    const FitErrors bad = fit_errors({zero, Law::kNeoHookean, 0.4, "", evaluation}, 4000);
    EXPECT_GT(bad.stress_median, 1e-3);
    EXPECT_FALSE(within(bad));
  }
  std::vector<float> loud(zero);
  for (size_t k = 0; k < loud.size(); ++k) loud[k] = float(std::sin(double(k))) * 1e3f;
  EXPECT_FALSE(within(fit_errors({loud, Law::kHencky, 0.4, "", Evaluation::kNet}, 1000)));
}

}  // namespace
}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
#include "training/fit_material.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(FitMaterial, ReadsAListOfMaterials) {
  const auto list = read_fit_materials(
      "# a comment\n\nsoft, neo-hookean, 0.1 # its end\n mix , 0.25*stvk + 0.75*hencky, 0.495\n",
      "list");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].name, "soft");
  EXPECT_EQ(list[0].terms.size(), 1u);
  EXPECT_EQ(list[0].poisson, 0.1);
  EXPECT_EQ(list[1].name, "mix");
  ASSERT_EQ(list[1].terms.size(), 2u);
  EXPECT_EQ(list[1].terms[0].law, Law::kStvk);
  EXPECT_EQ(list[1].terms[0].weight, 0.25);
  EXPECT_EQ(list[1].terms[1].law, Law::kHencky);
  EXPECT_EQ(law_text(list[1].terms), "0.25*stvk+0.75*hencky");
}

TEST(FitMaterial, NamesItselfAfterLawAndPoissonRatio) {
  EXPECT_EQ(fit_material("neo-hookean", 0.45).name, "neo-hookean-0.45");
}

TEST(FitMaterial, HasYoungsModulusOne) {
  const FitMaterial m = fit_material("stvk", 0.3);
  EXPECT_NEAR(m.mu() * (3 * m.lambda() + 2 * m.mu()) / (m.lambda() + m.mu()), 1, 1e-15);
}

TEST(FitMaterial, NamesTheLineOfAnError) {
  // the message, or that the list was accepted
  const auto message = [](const std::string& text) {
    try {
      read_fit_materials(text, "list");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto names = [&](const std::string& text, const char* part) {
    return message(text).find(part) != std::string::npos;
  };
  // each fault is named
  EXPECT_TRUE(names("a, stvk, 0\nb, jam, 0\n", "line 2"));
  EXPECT_TRUE(names("a, stvk\n", "line 1"));
  EXPECT_TRUE(names("a, stvk, 0.3x\n", "not a number"));
  EXPECT_TRUE(names("a, stvk, 0.5\n", "Poisson"));
  EXPECT_TRUE(names("a, stvk, -0.1\n", "Poisson"));
  EXPECT_TRUE(names("a, stvk, nan\n", "Poisson"));
  EXPECT_TRUE(names("a, stvk, 0\na, stvk, 0.1\n", "twice"));
  EXPECT_TRUE(names("../a, stvk, 0\n", "no name"));
  EXPECT_TRUE(names(".., stvk, 0\n", "no name"));
  EXPECT_TRUE(names("a, 0.5*stvk, 0\n", "sum"));
  EXPECT_TRUE(names("a, 2*stvk+-1*hencky, 0\n", "above 0"));
  EXPECT_TRUE(names("# nothing\n", "no materials"));
}

}  // namespace
}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// Which verbs take holds, moves and loads.
#include "cli/options.hpp"
#include "core/error.hpp"
#include "tests/cli/typed_words.hpp"
#include "tests/io/test_files.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::animate_options, test::parsed_words, test::refusal, test::simulate_options;
using test::error_of, test::expect_says, test::TempFolder;

TEST(LoadOptions, BothVerbsTakeHoldsMovesAndLoads) {
  const TempFolder folder;
  for (const auto& [option, text] : {std::pair("--hold", "all: x"),
                                     {"--traction", "all: 1,0,0"},
                                     {"--force", "all: 1,0,0"},
                                     {"--move", "all: shift 0:0,0,0"}}) {
    EXPECT_NO_THROW(simulate_options({"a.obj", "-o", "a.glb", option, text}));
    EXPECT_NO_THROW(animate_options({"a.obj", "-o", "a.glb", option, text}));
    expect_says(error_of(
                    [&] {
                      parsed_words({"study", "a.obj", option, text});
                    },
                    ErrorKind::kUsage),
                option);
  }
  // wind too, and state files have it
  EXPECT_NO_THROW(animate_options({"a.obj", "-o", "a.glb", "--wind", "1,0,0", "--state", "s.h5"}));
  EXPECT_NO_THROW(simulate_options({"a.obj", "-o", "a.glb", "--wind", "1,0,0"}));
  const std::string scene = folder.write("s.toml", "[[hold]]\nselect = 'all'\naxes = 'x'\n");
  const AnimateOptions held = animate_options({"a.obj", "-o", "a.glb", "--scene", scene});
  ASSERT_EQ(held.holds.size(), 1u);
  EXPECT_EQ(held.holds[0].text, "all: x");
}

}  // namespace
}  // namespace elastogen

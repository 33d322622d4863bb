// SPDX-License-Identifier: Apache-2.0
#include "voxelize/regions.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

const PlacedBox kBox = {{{1, 2, 3}, {3, 6, 4}}};

bool is_in(const char* text, const Vec3& point) {
  return contains(parse_selection(text), point, kBox);
}

TEST(Regions, HalfSpacesTakeLengthsAndSharesOfTheBox) {
  EXPECT_TRUE(is_in("y<5%", {0, 2.19, 0}));
  EXPECT_FALSE(is_in("y<5%", {0, 2.21, 0}));
  EXPECT_TRUE(is_in("x > 95%", {2.91, 0, 0}));
  EXPECT_FALSE(is_in("x>95%", {2.89, 0, 0}));
  EXPECT_TRUE(is_in("z>0.2m", {0, 0, 0.21}));
  EXPECT_FALSE(is_in("z>=0.2", {0, 0, 0.19}));
  EXPECT_TRUE(is_in(" x <= 3 cm", {0.029, 0, 0}));
  EXPECT_FALSE(is_in("x<=3cm", {0.031, 0, 0}));
  EXPECT_TRUE(is_in("y<-10%", {0, 1.59, 0}));
}

TEST(Regions, TheBorderBelongsToTheRegion) {
  for (const char* text : {"y<50%", "y>50%", "y<4", "y>=4000mm"})
    EXPECT_TRUE(is_in(text, {0, 4, 0})) << text;
}

TEST(Regions, BoxesAndSpheresAreClosed) {
  EXPECT_TRUE(is_in("box(0,0,0,1,2cm,3)", {1, 0.02, 3}));
  EXPECT_FALSE(is_in("box(0,0,0,1,2cm,3)", {1, 0.021, 3}));
  EXPECT_TRUE(is_in("box(0%,0%,0%,50%,50%,100%)", {2, 4, 4}));
  EXPECT_FALSE(is_in("box(0%,0%,0%,50%,50%,100%)", {2.01, 4, 4}));
  EXPECT_TRUE(is_in("sphere(0, 0, 1, 50cm)", {0.3, 0.4, 1}));
  EXPECT_FALSE(is_in("sphere(0,0,1,50cm)", {0.31, 0.4, 1}));
  EXPECT_TRUE(is_in("all", {1e9, -1e9, 0}));
}

TEST(Regions, PartsOfTheAssetAreReadWithTheirNames) {
  // names and colours
  const Selection node = parse_selection(" node: left hand:1 ");
  EXPECT_EQ(node.kind, Selection::Kind::kNode);
  EXPECT_EQ(node.name, "left hand:1");
  EXPECT_EQ(parse_selection("material:Skin*").kind, Selection::Kind::kMaterial);
  EXPECT_EQ(parse_selection("material:Skin*").name, "Skin*");
  for (const char* text : {"colour:#ff8001", "color: #FF8001"}) {
    const Selection colour = parse_selection(text);
    EXPECT_EQ(colour.kind, Selection::Kind::kColour) << text;
    EXPECT_EQ(colour.colour, (std::array<uint8_t, 3>{255, 128, 1})) << text;
  }
  // comparisons
  struct Row {
    const char* text;
    bool below, with_bound;
  };
  for (const auto& [text, below, with_bound] : {Row{"attr:w.x>-0.5", false, false},
                                                {"attr: w.x >= -5e-1", false, true},
                                                {"attr:w.x<-0.5", true, false},
                                                {"attr:w.x <=-0.5 ", true, true}}) {
    const Selection attribute = parse_selection(text);
    EXPECT_EQ(attribute.kind, Selection::Kind::kAttribute) << text;
    EXPECT_EQ(attribute.name, "w.x") << text;
    EXPECT_EQ(attribute.bound, -0.5) << text;
    EXPECT_EQ(attribute.below, below) << text;
    EXPECT_EQ(attribute.with_bound, with_bound) << text;
    EXPECT_FALSE(attribute.is_place());
    EXPECT_FALSE(plane(attribute, kBox));
  }
  EXPECT_TRUE(parse_selection("all").is_place());
}

TEST(Regions, ASelectionEndsAtTheColonThatABlankFollows) {
  const auto parts = [](const char* text) { return split_selection(text); };
  using Pair = std::pair<std::string_view, std::string_view>;
  EXPECT_EQ(parts("x>99%:shift 0: 0,0,0"), (Pair{"x>99%", "shift 0: 0,0,0"}));
  EXPECT_EQ(parts(" node:rig:Hips: shift 0:0,0,0"), (Pair{"node:rig:Hips", "shift 0:0,0,0"}));
  EXPECT_EQ(parts("node:Hips:xy"), (Pair{"node:Hips", "xy"}));
  EXPECT_EQ(parts("colour:#ff0000: 1 kPa"), (Pair{"colour:#ff0000", "1 kPa"}));
  EXPECT_EQ(parts("attr:w>0.5:\t1,0,0"), (Pair{"attr:w>0.5", "1,0,0"}));
  EXPECT_THROW(parts("x>99%"), Error);
  EXPECT_THROW(parts("node:Hips"), Error);
}

TEST(Regions, SelectNodesByTheirRestPosition) {
  const VoxelGrid grid = make_box(4, 4, 4, 0.25);
  const PlacedBox box = {{{0, 0, 0}, {1, 1, 1}}};
  const Array<uint8_t> selected = select_nodes(grid, parse_selection("x<25%"), box);
  int64_t count = 0;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    EXPECT_EQ(selected(n), grid.node_coord(n, 0) <= 1);
    count += selected(n);
  }
  EXPECT_EQ(count, 50);
}

TEST(Regions, HalfSpacesHaveAPlaneToAlignWith) {
  EXPECT_EQ(plane(parse_selection("y<5%"), kBox)->first, 1);
  EXPECT_DOUBLE_EQ(plane(parse_selection("y<5%"), kBox)->second, 2.2);
  EXPECT_DOUBLE_EQ(plane(parse_selection("z>12cm"), kBox)->second, 0.12);
  EXPECT_FALSE(plane(parse_selection("all"), kBox));
  EXPECT_FALSE(plane(parse_selection("sphere(0,0,0,1)"), kBox));
}

void expect_refused(const char* text) {
  try {
    parse_selection(text);
    ADD_FAILURE() << "accepted: " << text;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(message.find(concat("'", text, "'")), std::string::npos) << message;
    EXPECT_NE(message.find("sphere(x,y,z,RADIUS)"), std::string::npos) << message;
    EXPECT_NE(message.find("attr:NAME>NUMBER"), std::string::npos) << message;
  }
}

TEST(Regions, RefuseWithTheTextTheReasonAndTheGrammar) {
  for (const char* text : {"", "y", "y<", "w<5%", "y=3", "y<5%%", "y<3 parsec", "box(1,2,3)",
                           "box(0,0,0,1,1,1", "box(1,0,0,0,1,1)", "sphere(0,0,0,-1)",
                           "sphere(0,0,0,5%)", "all of it", "y<nan", "y<1 0%", "box(0 0,0, 1,1,1)"})
    expect_refused(text);
}

TEST(Regions, RefusePartsWithoutANameAColourOrAComparison) {
  for (const char* text :
       {"node:", "material: ", "colour:red", "colour:#ff00", "colour:#ff00zz", "colour:#-f0000",
        "attr:w", "attr:>1", "attr:w>", "attr:w>heavy", "attr:w=1", "Node:a"})
    expect_refused(text);
}

}  // namespace
}  // namespace elastogen

// SPDX-License-Identifier: Apache-2.0
// Pins, moves and loads of parts that an asset names or paints.
#include "scene/asset_part.hpp"

#include "core/error.hpp"
#include "scene/carried_points.hpp"
#include "scene/fem_scene.hpp"
#include "scene/name_pattern.hpp"
#include "scene/paint.hpp"
#include "scene/set_up.hpp"
#include "scene/stepper.hpp"
#include "tests/scene/two_part_bar.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kH = 0.05;

/// A run whose grid fits the bar and its parts.
RunDescription part_run(const std::vector<std::string>& pins,
                        const std::vector<std::string>& moves = {}) {
  RunDescription run;
  run.h = kH;
  run.solver.device = Device::kCpu;
  run.material = {.young = 1e6, .poisson = 0.3, .density = 1000};
  run.gravity = Vec3{0, -9.81, 0};
  run.fem = FemOptions{.statics = true};
  for (const std::string& text : pins) run.pins.push_back(parse_pin(text));
  for (const std::string& text : moves) run.moves.push_back(parse_move(text));
  return run;
}

/// Nodes of the bar up to its second ring.
bool in_grip(const VoxelGrid& grid, int64_t n) {
  return grid.rest(n, 0) < 0.2 + kH / 2;
}

std::string refusal(const Asset& asset, const RunDescription& run) {
  try {
    set_up(asset, run);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    return error.what();
  }
  return "";
}

void expect_has(const std::string& text, const std::string& words) {
  EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(AssetPart, OfWhateverKindHoldsTheNodesOfItsVoxels) {
  for (const bool two : {false, true})
    for (const std::string pin :
         {"material:Rubber*", "attr:w>=1", "attr:_W>0.999", "colour:#ff0000", "color:#f00a0a",
          "node:grip", "node:ha*", "node:*rip"}) {
      if (!two && pin.starts_with("node")) continue;
      const auto setup = set_up(two_part_bar(two), part_run({pin}));
      const VoxelGrid& grid = setup.scene.grid;
      int64_t pinned = 0;
      for (int64_t n = 0; n < grid.node_count(); ++n) {
        EXPECT_EQ(setup.scene.pinned(n) == kPinnedNode, in_grip(grid, n)) << pin;
        EXPECT_EQ(setup.scene.holder(n) == 0, in_grip(grid, n)) << pin;
        pinned += setup.scene.pinned(n);
      }
      EXPECT_EQ(pinned, 5 * 5 * 5) << pin;
      EXPECT_EQ(setup.scene.holders.at(0).name, "--pin '" + pin + "'");
    }
}

TEST(AssetPart, TheValueBetweenPaintedVerticesDecides) {
  // w falls from 1 at 0.2 m to 0 at 1 m: above 1/2 up to 0.6 m, so voxels up to there
  const auto setup = set_up(two_part_bar(false), part_run({"attr:w>0.5"}));
  const VoxelGrid& grid = setup.scene.grid;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    EXPECT_EQ(setup.scene.pinned(n) == kPinnedNode, grid.rest(n, 0) < 0.6 + kH / 2);
  const auto below = set_up(two_part_bar(false), part_run({"attr:w<0.5"}));
  for (int64_t n = 0; n < grid.node_count(); ++n)
    EXPECT_EQ(below.scene.pinned(n) == kPinnedNode, grid.rest(n, 0) > 0.6 - kH / 2);
}

TEST(AssetPart, TheBoundBelongsToItOnlyWhereItIsAskedFor) {
  const Asset asset = two_part_bar(false);
  const auto painted = [&](const char* text) {
    const Paint paint(asset, parse_selection(text));
    int64_t count = 0;
    for (int32_t v = 0; v < 12; ++v) count += paint.at_vertex(asset.meshes[0], v);
    return count;
  };
  EXPECT_EQ(painted("attr:w>1"), 0);
  EXPECT_EQ(painted("attr:w>=1"), 8);
  EXPECT_EQ(painted("attr:w<0"), 0);
  EXPECT_EQ(painted("attr:w<=0"), 4);
  // equal values stay what they are between vertices, whatever the weights
  const Paint paint(asset, parse_selection("attr:w>=1"));
  EXPECT_TRUE(paint.at({&asset.meshes[0], {0, 1, 2}}, {0.1, 0.2, 0.7 - 1e-16}));
}

TEST(AssetPart, AColourIsThatOfTheScreenWithin16OfEachChannel) {
  Asset asset = two_part_bar(false);
  // linear 0.215861 is sRGB 128 (0x80), by IEC 61966-2-1
  for (auto& colour : asset.meshes[0].colour) colour = {0.2158605f, 0, 0, 1};
  const auto has = [&](const char* text) {
    return Paint(asset, parse_selection(text)).at_vertex(asset.meshes[0], 0);
  };
  EXPECT_TRUE(has("colour:#800000"));
  EXPECT_TRUE(has("colour:#900010"));
  EXPECT_TRUE(has("colour:#701000"));
  EXPECT_FALSE(has("colour:#910000"));
  EXPECT_FALSE(has("colour:#6f0000"));
  EXPECT_FALSE(has("colour:#800011"));
  EXPECT_FALSE(has("colour:#370000"));  // 0.2158605 of 255
}

TEST(AssetPart, ItsVerticesRestExactlyAndOthersDoNot) {
  for (const bool two : {false, true})
    for (const char* pin : {"material:Rubber grip", "attr:w>=1", "colour:#ff0000"}) {
      RunDescription run = part_run({pin});
      run.h = 0.055;  // fits nothing
      const auto setup = set_up(two_part_bar(two), run);
      const CarriedPoints points = carried_points(setup);
      EXPECT_TRUE(points.moved.empty());
      // free nodes go anywhere; those that the pin holds rest
      Array<double> x = setup.scene.grid.rest, u(points.count, 3);
      for (int64_t k = 0; k < x.size(); ++k)
        if (setup.scene.pinned(k / 3) == kFreeNode) x.data()[k] += 0.01 * double(1 + k % 7);
      deform_asset(setup.scene.grid, points.embedding, x, u);
      int64_t resting = 0;
      for (int64_t p = 0; p < points.count; ++p) {
        const bool held = setup.body.carried(p, 0) < 0.3;
        resting += held;
        for (int d = 0; d < 3; ++d) EXPECT_EQ(u(p, d) == 0, held) << pin << ' ' << p;
      }
      EXPECT_EQ(resting, two ? 12 : 8);
    }
}

TEST(AssetPart, TheGridCarriesItsVerticesAsTheyAreWritten) {
  // the nodes that carry a vertex are held, so that what is written is what the voxels do
  RunDescription run = part_run({"material:Rubber*"});
  run.h = 0.055;
  const auto setup = set_up(two_part_bar(false), run);
  const Embedding embedding = embed(setup.scene.grid, setup.body.carried);
  for (int64_t p = 0; p < 8; ++p)
    for (int c = 0; c < 8; ++c) {
      if (std::abs(embedding.weights(p, c)) < 1e-5) continue;
      EXPECT_EQ(setup.scene.pinned(setup.scene.grid.corners(embedding.voxel(p), c)), kPinnedNode);
    }
}

TEST(AssetPart, VerticesAtAPlaceOfItRestWhateverTheirPaint) {
  Asset asset = two_part_bar(true);
  // the second mesh has no red at the seam
  std::ranges::fill(asset.meshes[1].colour, std::array<float, 4>{0, 0, 1, 1});
  const auto setup = set_up(asset, part_run({"colour:#ff0000"}));
  const AssetPart& part = setup.parts.at(0);
  int64_t count = 0;
  for (int64_t p = 0; p < part.points.rows(); ++p) {
    EXPECT_EQ(part.points(p) != 0, setup.body.carried(p, 0) < 0.3) << p;
    count += part.points(p);
  }
  EXPECT_EQ(count, 12);
}

/// Displacements of the vertices in equilibrium.
Array<double> still(const RunDescription& run) {
  const auto setup = set_up(two_part_bar(false), run);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin({});
  EXPECT_TRUE(stepper->advance().converged);
  const CarriedPoints points = carried_points(setup);
  Array<double> u(points.count, 3);
  deform_asset(setup.scene.grid, points.embedding, stepper->state().x, u);
  place_moved(points, setup, 1, u, nullptr);
  return u;
}

void expect_same(const RunDescription& a, const RunDescription& b, double least) {
  const Array<double> of_a = still(a), of_b = still(b);
  double most = 0;
  for (int64_t k = 0; k < of_a.size(); ++k) {
    most = std::max(most, std::abs(of_a.data()[k]));
    EXPECT_NEAR(of_a.data()[k], of_b.data()[k], 1e-7);
  }
  EXPECT_GT(most, least);
}

TEST(AssetPart, APinOfItIsThePlaneThatFitsTheSameVoxels) {
  for (const char* pin : {"material:Rubber*", "attr:w>=1"})
    expect_same(part_run({pin}), part_run({"x<20%"}), 1e-2);
}

TEST(AssetPart, AMoveOfItIsThatOfThePlaneAndCarriesItsVerticesExactly) {
  const std::string turn = ": turn(0,50%,50%, 0,0,1) 0:0; 1:0.3";
  expect_same(part_run({}, {"material:Rubber*" + turn}), part_run({}, {"x<20%" + turn}), 5e-2);
  const auto setup = set_up(two_part_bar(false), part_run({}, {"colour:#ff0000" + turn}));
  const CarriedPoints points = carried_points(setup);
  ASSERT_EQ(points.moved.size(), 8u);
  Array<double> u(points.count, 3);
  place_moved(points, setup, 1, u, nullptr);
  for (int64_t p = 0; p < 8; ++p) {
    const double x = setup.body.carried(p, 0), y = setup.body.carried(p, 1) - 0.1;
    EXPECT_NEAR(u(p, 0), std::cos(0.3) * x - std::sin(0.3) * y - x, 1e-15);
    EXPECT_NEAR(u(p, 1), std::sin(0.3) * x + std::cos(0.3) * y - y, 1e-15);
    EXPECT_EQ(u(p, 2), 0);
  }
}

TEST(AssetPart, LoadsAndHoldsTakeItToo) {
  RunDescription part = part_run({"x>100%"}), plane = part_run({"x>100%"});
  part.tractions.push_back(parse_traction("material:Rubber*: 0,-5,0 N"));
  plane.tractions.push_back(parse_traction("x<20%: 0,-5,0 N"));
  part.forces.push_back(parse_force("attr:w>=1: 0: 0,0,0 N; 1: 0,-3,0 N"));
  plane.forces.push_back(parse_force("x<20%: 0: 0,0,0 N; 1: 0,-3,0 N"));
  part.holds.push_back(parse_hold("colour:#ff0000: x"));
  plane.holds.push_back(parse_hold("x<20%: x"));
  expect_same(part, plane, 1e-3);
}

TEST(AssetPart, NamesThatTheAssetLacksAreRefusedWithThoseItHas) {
  const Asset asset = two_part_bar(true);
  expect_has(refusal(asset, part_run({"node:Grip"})),
             "--pin 'node:Grip': the asset has no node 'Grip'; it has 'grip', 'hand', 'rest'");
  expect_has(refusal(asset, part_run({"material:wood"})), "it has 'Rubber grip', 'Wood'");
  expect_has(refusal(asset, part_run({"attr:weight>0"})),
             "--pin 'attr:weight>0': the asset has no attribute 'weight'; it has '_W'");
  expect_has(refusal(asset, part_run({}, {"node:x*: shift 0:0,0,0"})), "--move 'node:x*: shift");
  Asset bare = asset;
  for (Mesh& mesh : bare.meshes) mesh.colour.clear(), mesh.attributes.clear();
  expect_has(refusal(bare, part_run({"colour:#000000"})), "has no colours of vertices");
  expect_has(refusal(bare, part_run({"attr:w>0"})), "it has none");
}

TEST(AssetPart, ANodeWithoutANameHasThatOfItsMesh) {
  Asset asset = two_part_bar(true);
  asset.nodes[1].name = "";
  asset.meshes[0].name = "Handle";
  const auto setup = set_up(asset, part_run({"node:Handle"}));
  for (int64_t n = 0; n < setup.scene.grid.node_count(); ++n)
    EXPECT_EQ(setup.scene.pinned(n) == kPinnedNode, in_grip(setup.scene.grid, n));
}

TEST(AssetPart, ThatHoldsNothingIsAWarningByName) {
  for (const char* pin : {"colour:#00ff00", "attr:w>2", "node:hand2*"}) {
    Asset asset = two_part_bar(true);
    asset.nodes.push_back({"hand2 empty", -1, kIdentity4, -1});
    const auto setup = set_up(asset, part_run({pin}));
    EXPECT_TRUE(std::ranges::any_of(setup.warnings, [&](const std::string& text) {
      return text.find("--pin '" + std::string(pin) + "' holds nothing") != text.npos;
    })) << pin;
  }
}

TEST(AssetPart, AMoveAndAnotherHolderOfItAreRefusedByName) {
  const Asset asset = two_part_bar(true);
  const std::string shift = ": shift 0:0,0,0; 1:0.1,0,0";
  for (const char* pin : {"node:grip", "x<5%", "attr:w>0.5", "node:rest"}) {
    const std::string text = refusal(asset, part_run({pin}, {"material:Rubber*" + shift}));
    expect_has(text, "contradict each other");
    expect_has(text, pin);
    expect_has(text, "--move 'material:Rubber*");
  }
  EXPECT_EQ(refusal(asset, part_run({"x>90%"}, {"material:Rubber*" + shift})), "");
}

TEST(AssetPart, HoldsABodyWhoseOtherPinCutsVoxels) {
  const auto setup =
      set_up(two_part_bar(false), part_run({"material:Rubber*", "sphere(100%,50%,50%,0.07m)"}));
  EXPECT_FALSE(setup.scene.dependent.empty());
  const VoxelGrid& grid = setup.scene.grid;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    if (in_grip(grid, n)) {
      EXPECT_EQ(setup.scene.holder(n), 0);
    }
    if (grid.rest(n, 0) > 0.3 && grid.rest(n, 0) < 0.9) {
      EXPECT_EQ(setup.scene.pinned(n), kFreeNode);
    }
  }
}

TEST(AssetPart, OfPointsAreColoursAndAttributesOfTheNearest) {
  Asset asset;
  asset.path = "bar.xyz";
  // a cloud of the bar's surface
  PointCloud& cloud = asset.points.emplace();
  cloud.own.columns = {{"label", PlyType::kUint8}, {"w", PlyType::kFloat32}};
  const auto add = [&](double x, double y, double z) {
    const bool held = x < 0.3;
    cloud.position.push_back({x, y, z});
    cloud.colour.push_back({float(held), 0, float(!held), 1});
    cloud.own.add(0, held ? 7 : 3);
    cloud.own.add(1, x);
  };
  const int n = 20;
  for (int i = 0; i <= 5 * n; ++i)
    for (int k = 0; k < n; ++k) {
      const double x = 1.0 * i / (5 * n), t = 0.2 * k / n;
      add(x, t, 0), add(x, 0.2, t), add(x, 0.2 - t, 0.2), add(x, 0, 0.2 - t);
    }
  for (int i = 1; i < n; ++i)
    for (int k = 1; k < n; ++k)
      for (const double x : {0.0, 1.0}) add(x, 0.2 * i / n, 0.2 * k / n);
  // pins by each of its paints
  for (const char* pin : {"colour:#ff0000", "attr:label>=7", "attr:W<0.3"}) {
    const auto setup = set_up(asset, part_run({pin}));
    for (int64_t p = 0; p < setup.body.carried.rows(); ++p)
      EXPECT_EQ(setup.parts.at(0).points(p) != 0, cloud.position[size_t(p)][0] < 0.2999);
    const VoxelGrid& grid = setup.scene.grid;
    for (int64_t k = 0; k < grid.node_count(); ++k) {
      if (grid.rest(k, 0) < 0.3 - kH) {
        EXPECT_EQ(setup.scene.pinned(k), kPinnedNode) << pin;
      }
      if (grid.rest(k, 0) > 0.3 + 2 * kH) {
        EXPECT_EQ(setup.scene.pinned(k), kFreeNode) << pin;
      }
    }
  }
  expect_has(refusal(asset, part_run({"node:bar"})), "select by place, colour or attribute");
}

TEST(NamePattern, StarsStandForAnyLettersAndAttributesForgiveCase) {
  EXPECT_TRUE(matches("a*c*", "abcabc"));
  EXPECT_FALSE(matches("a*d", "abc"));
  EXPECT_FALSE(matches("A", "a"));
  EXPECT_TRUE(matches_attribute("weight", "_WEIGHT"));
  EXPECT_TRUE(matches_attribute("_Weight.x", "weight.X"));
  EXPECT_FALSE(matches_attribute("weight", "__WEIGHT"));
  EXPECT_EQ(quoted_names({"b", "", "a"}), "'a', 'b'");
  EXPECT_EQ(quoted_names({}), "none with a name");
}

}  // namespace
}  // namespace elastogen

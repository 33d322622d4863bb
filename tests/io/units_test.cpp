// SPDX-License-Identifier: Apache-2.0
#include "io/units.hpp"

#include "tests/io/test_files.hpp"

#include <numbers>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

TEST(Units, ConvertToSi) {
  EXPECT_DOUBLE_EQ(parse_length("30 cm"), 0.3);
  EXPECT_DOUBLE_EQ(parse_length("30cm"), 0.3);
  EXPECT_DOUBLE_EQ(parse_length(" 1 in "), 0.0254);
  EXPECT_DOUBLE_EQ(parse_length("2.5e-3"), 0.0025);
  EXPECT_DOUBLE_EQ(parse_length("-3um"), -3e-6);
  EXPECT_DOUBLE_EQ(parse_pressure("3 GPa"), 3e9);
  EXPECT_DOUBLE_EQ(parse_pressure("+2e5 Pa"), 2e5);
  EXPECT_NEAR(parse_pressure("1 psi"), 6894.757293168361, 1e-9);  // NIST SP 811
  EXPECT_DOUBLE_EQ(parse_density("1.1 g/cm3"), 1100);
  EXPECT_DOUBLE_EQ(parse_density("1000 kg/m^3"), 1000);
  EXPECT_DOUBLE_EQ(parse_time("10 ms"), 0.01);
  EXPECT_DOUBLE_EQ(parse_time("2 min"), 120);
  EXPECT_DOUBLE_EQ(parse_speed("36 km/h"), 10);
  EXPECT_DOUBLE_EQ(parse_angle("180 deg"), std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_spin("60 rpm"), 2 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_quantity("1 g0", Quantity::kAcceleration), 9.80665);
  EXPECT_DOUBLE_EQ(parse_quantity("10 N", Quantity::kForce), 10);
  EXPECT_DOUBLE_EQ(parse_quantity("2 kN", Quantity::kForce), 2000);
  EXPECT_NEAR(parse_quantity("1 lbf", Quantity::kForce), 4.4482216152605, 1e-13);  // NIST SP 811
  EXPECT_EQ(parse_memory("4 GiB"), int64_t{1} << 32);
  EXPECT_EQ(parse_memory("1.5kB"), 1500);
  EXPECT_DOUBLE_EQ(parse_number("0.45"), 0.45);
}

TEST(Units, ReadVectors) {
  EXPECT_EQ(parse_vec3("0,-9.81,0"), (Vec3{0, -9.81, 0}));
  EXPECT_EQ(parse_vec3(" 1 , 2,3 "), (Vec3{1, 2, 3}));
  EXPECT_EQ(parse_vec3("1,2,3 cm", Quantity::kLength), (Vec3{0.01, 0.02, 0.03}));
}

TEST(Units, ErrorsNameTheTextAndTheKnownUnits) {
  const auto says = [](auto call, const char* part) {
    expect_says(error_of(call, ErrorKind::kUsage), part);
  };
  says([] { parse_length("3 furlongs"); },
       "\"furlongs\" is not a unit known here; known are m, nm");
  says([] { parse_pressure("3 gpa"); }, "known are Pa, kPa, MPa, GPa, bar, psi");
  says([] { parse_length("3 Pa"); }, "\"3 Pa\"");
  for (const char* text : {"", "  ", "cm", "nan", "inf", "1e999", "0x", "1,5", "1 2", "--1", "+"})
    says([&] { parse_length(text); }, text);
  says([] { parse_length("1e308 km"); }, "not finite in SI units");
  says([] { parse_number("3 m"); }, "a number without a unit is expected");
  says([] { parse_memory("-1"); }, "no amount of memory");
  says([] { parse_memory("1e30"); }, "no amount of memory");
  for (const char* text : {"1,2", "1 2 3", "1,2,", ",,", "1,2,3,4", "1,nan,2", "1;2;3"})
    says([&] { parse_vec3(text); }, text);
}

}  // namespace
}  // namespace elastogen

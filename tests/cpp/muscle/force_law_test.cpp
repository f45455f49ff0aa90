#include "muscle/force_law.hpp"

#include "../fixture.hpp"

namespace glossa::test {

TEST_CASE("force law: eq. 3, exp(c A) - 1 up to the capacity") {
  const ForceLaw law;
  CHECK(law.level(-0.001) == 0.0);
  CHECK(law.level(0.0) == 0.0);
  CHECK_WITHIN(std::abs(law.level(0.010) - 0.49182469764127035), 1e-15);              // exp(0.4) - 1
  CHECK_WITHIN(std::abs(law.saturation_activation() - 0.017328679513998633), 1e-17);  // ln 2 / 40
  CHECK(law.level(law.saturation_activation()) == 1.0);
  CHECK_WITHIN(1.0 - law.level(law.saturation_activation() * (1.0 - 1e-9)), 2e-9);  // slope 2 ln 2 times 1e-9
  CHECK(law.level(1.0) == 1.0);
  CHECK(ForceLaw{.c = 112.0}.level(0.005) == std::expm1(0.56));
}

TEST_CASE("force law: slope and integral of the level against differences") {
  const ForceLaw law;
  for (const double a : {0.001, 0.008, 0.017}) {
    const double by_differences = slope([&](double h) { return law.level(a + h); }, 1e-4);
    CHECK_WITHIN(std::abs(by_differences / law.level_slope(a) - 1.0), 3e-10);  // truncation (c h)^4
  }
  for (const double a : {0.001, 0.008, 0.017, 0.019, 0.03}) {
    const double by_differences = slope([&](double h) { return law.level_integral(a + h); }, 1e-4);
    CHECK_WITHIN(std::abs(by_differences / law.level(a) - 1.0), 3e-10);  // as above
  }
  const double top = law.saturation_activation();
  CHECK_WITHIN(std::abs(law.level_integral(top) - law.level_integral(top * (1 - 1e-12))),
               1e-13);  // level(top) = 1 times the gap
  for (const double a : {-0.01, 0.0, top, 0.03}) CHECK(law.level_slope(a) == 0.0);
  CHECK(law.level_integral(-0.01) == 0.0);
}

TEST_CASE("force law: eq. 5 is 1.00004 at rest, rises with lengthening, and is held at zero when shortening fast") {
  const ForceLaw law;
  CHECK_WITHIN(std::abs(law.velocity_factor(0.0) - 1.000041817522142), 1e-15);  // 0.7109 + 0.712 atan 0.43
  CHECK_WITHIN(std::abs(law.velocity_factor(1.0) - 1.255364933792380), 1e-15);
  CHECK_WITHIN(std::abs(law.velocity_factor(-1.0) - 0.667747908585379), 1e-15);
  CHECK(law.velocity_factor(-3.4) > 0.0);
  CHECK(law.velocity_factor(-3.6) == 0.0);
  CHECK(law.velocity_factor(-30.0) == 0.0);
  for (const double v : {-3.0, -0.5, 0.0, 2.0}) {
    const double by_differences = slope([&](double h) { return law.velocity_factor(v + h); }, 1e-3);
    CHECK_WITHIN(std::abs(by_differences / law.velocity_slope(v) - 1.0), 1e-11);
  }
  CHECK(law.velocity_slope(-5.0) == 0.0);
}

TEST_CASE("force law: without force-velocity the factor is 1") {
  const ForceLaw law{.force_velocity = false};
  for (const double v : {-30.0, 0.0, 2.0}) {
    CHECK(law.velocity_factor(v) == 1.0);
    CHECK(law.velocity_slope(v) == 0.0);
  }
}

}  // namespace glossa::test

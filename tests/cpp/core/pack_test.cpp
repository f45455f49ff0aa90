#include "core/pack.hpp"

#include "../fixture.hpp"

namespace glossa::test {

TEST_CASE("pack: inverse cube root against std::cbrt") {
  Random random(1);
  double worst = 0.0;
  for (int k = 0; k < 100000; ++k) {
    const Pack x = {std::pow(10.0, random(-6, 6)), std::pow(10.0, random(-6, 6)), random(0.5, 1.6), 1.0 + random(-1e-9, 1e-9)};
    const Pack y = inverse_cube_root(x);
    for (int lane = 0; lane < lanes; ++lane) worst = std::max(worst, std::abs(y[lane] * std::cbrt(x[lane]) - 1.0));
  }
  // Three roundings of the last Newton sweep, one of cbrt, one of the product.
  CHECK_WITHIN(worst, 8e-16);
}

TEST_CASE("pack: inverse cube root is exact to rounding at cubes") {
  for (const double root : {0.5, 1.0, 2.0, 3.0, 10.0})
    CHECK_WITHIN(std::abs(inverse_cube_root(splat(root * root * root))[2] * root - 1.0), 8e-16);
}

}  // namespace glossa::test

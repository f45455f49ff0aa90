#include "core/pack.hpp"

#include "../fixture.hpp"

namespace glossa::test {
namespace {

/// Relative error of y = x^(-1/3), by an oracle of more digits.
double error_of(double y, double x) {
  return static_cast<double>(std::abs(static_cast<long double>(y) * std::cbrt(static_cast<long double>(x)) - 1.0L));
}

}  // namespace

TEST_CASE("pack: inverse cube root against std::cbrt, 1e-6 to 1e6") {
  Random random(1);
  double worst = 0.0;
  for (int k = 0; k < 100000; ++k) {
    const Pack x = {std::pow(10.0, random(-6, 6)), std::pow(10.0, random(-6, 6)), random(0.5, 1.6),
                    1.0 + random(-1e-9, 1e-9)};
    const Pack y = inverse_cube_root(x);
    for (int lane = 0; lane < lanes; ++lane) worst = std::max(worst, error_of(y[lane], x[lane]));
  }
  CHECK_WITHIN(worst, 7e-16);  // the products of the last sweep and its constant 1/3 are rounded
}

TEST_CASE("pack: inverse cube root is exact to rounding at cubes") {
  for (const double root : {0.5, 1.0, 2.0, 3.0, 10.0}) {
    const double cube = root * root * root;
    CHECK_WITHIN(error_of(inverse_cube_root(splat(cube))[2], cube), 7e-16);
  }
}

TEST_CASE("pack: rows become columns, and corners are gathered from four doubles each") {
  Pack row[4];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) row[i][j] = 10 * i + j;
  transpose(row[0], row[1], row[2], row[3]);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) CHECK(row[i][j] == 10 * j + i);

  std::vector<double> field;
  for (int node = 0; node < 40; ++node)
    for (int i = 0; i < 4; ++i) field.push_back(10 * node + i);
  Index corner[8][lanes];
  for (int n = 0; n < 8; ++n)
    for (int lane = 0; lane < lanes; ++lane) corner[n][lane] = (7 * n + 11 * lane) % 40;
  Pack x[8][3];
  gather(field.data(), corner, x);
  for (int n = 0; n < 8; ++n)
    for (int i = 0; i < 3; ++i)
      for (int lane = 0; lane < lanes; ++lane) CHECK(x[n][i][lane] == 10 * corner[n][lane] + i);
}

}  // namespace glossa::test

#include "contact/spline_grid.hpp"

#include <algorithm>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

Lattice small_lattice() {
  return {Vector3(-0.011, 0.004, 0.1), 1.3e-3, {9, 8, 11}};
}

/// From samples f at all points, every brick with a block of its own but those that equal a shared one.
template <class Function>
SplineGrid splined(const Lattice& lattice, Function&& f, const std::vector<double>& uniform = {}, int threads = 1) {
  const LatticeBricks bricks(lattice);
  BrickValues<double> samples(uniform);
  std::vector<Index> block_of;
  for (int number = 0; number < bricks.count(); ++number) {
    std::vector<double> values;
    for (int point = 0; point < 64; ++point)
      values.push_back(f(bricks.point(number, point / 16, point / 4 % 4, point % 4)));
    Index block = 0;
    while (block < samples.shared && !std::equal(values.begin(), values.end(), samples.block(block))) ++block;
    if (block == samples.shared) {
      block = static_cast<Index>(samples.values.size() / 64);
      samples.values.insert(samples.values.end(), values.begin(), values.end());
    }
    block_of.push_back(block);
  }
  return {bricks, block_of, samples, threads};
}

/// A point at least two cells from the lattice's faces, where samples beyond them do not matter.
Vector3 inner_point(const Lattice& lattice, Random& random) {
  Vector3 t;
  for (int axis = 0; axis < 3; ++axis) t[axis] = random(2.0, lattice.size[static_cast<std::size_t>(axis)] - 3.0);
  return lattice.point(t.x(), t.y(), t.z());
}

}  // namespace

TEST_CASE("spline grid: cubic polynomials are reproduced, with gradient and Hessian") {
  Random random(8);
  std::array<double, 64> c{};
  for (double& x : c) x = random(-1, 1);
  const auto f = [&](const Vector3& y) {  // degree 3 in each coordinate, which are of the order of 1
    const Vector3 x = 100.0 * (y - Vector3(0, 0, 0.1));
    double sum = 0.0;
    for (int k = 0; k < 64; ++k)
      sum += c[static_cast<std::size_t>(k)] * std::pow(x.x(), k % 4) * std::pow(x.y(), k / 4 % 4) *
             std::pow(x.z(), k / 16);
    return sum;
  };
  const Lattice lattice = small_lattice();
  const SplineGrid spline = splined(lattice, f);
  for (int n = 0; n < 50; ++n) {
    const Vector3 x = inner_point(lattice, random);
    REQUIRE(spline.covers(x));
    Vector3 gradient, again;
    Matrix3 hessian;
    const double value = spline.value(x, gradient, hessian);
    CHECK_WITHIN(std::abs(value - f(x)), 1e-13);
    CHECK(spline.value(x) == value);
    CHECK(spline.value(x, again) == value);
    CHECK(again == gradient);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step = Vector3::Unit(axis);
      const double difference = slope([&](double h) { return f(x + h * step); }, 1e-4);
      CHECK_WITHIN(std::abs(gradient[axis] - difference), 1e-9);  // rounding over the step; size 100
      const auto change = derivative(
          [&](double h) {
            Vector3 g;
            spline.value(x + h * step, g);
            return g;
          },
          1e-5);
      CHECK_WITHIN((hessian.col(axis) - change).norm() / hessian.norm(), 1e-11);
    }
    CHECK(hessian.norm() > 100.0);
    CHECK(hessian == hessian.transpose());
  }
}

TEST_CASE("spline grid: twice differentiable for rough samples, across cells") {
  Random random(9);
  const Lattice lattice = small_lattice();
  const SplineGrid spline = splined(lattice, [&](const Vector3&) { return random(-1, 1); });
  for (int n = 0; n < 20; ++n) {
    Vector3 x = inner_point(lattice, random);
    x[n % 3] = lattice.origin[n % 3] + lattice.spacing * (3 + n % 2);  // on a plane between cells
    Vector3 gl, gr;
    Matrix3 hl, hr;
    const Vector3 step = 1e-12 * Vector3::Unit(n % 3);
    CHECK_WITHIN(std::abs(spline.value(x - step, gl, hl) - spline.value(x + step, gr, hr)), 1e-8);
    CHECK_WITHIN((gl - gr).norm() / gr.norm(), 1e-7);
    CHECK_WITHIN((hl - hr).norm() / hr.norm(), 1e-7);  // third derivatives jump: step over spacing
  }
}

TEST_CASE(
    "spline grid: local and constant where the samples are; the same by shared bricks and for any number of threads") {
  Lattice lattice = small_lattice();
  lattice.size = {70, 40, 30};
  Random random(10);
  // Rough, the same whenever asked; a quarter here, minus one half there.
  const auto f = [&](const Vector3& x) {
    if (x.x() < lattice.point(29.5, 0, 0).x()) return x.y() < lattice.point(0, 19.5, 0).y() ? 0.25 : -0.5;
    return std::sin(1e7 * (x.x() + 3.0 * x.y() + 7.0 * x.z()));
  };
  const SplineGrid spline = splined(lattice, f, {0.25, -0.5});
  Vector3 gradient;
  for (const double x : {6.4, 20.1, 26.4}) {
    CHECK(spline.value(lattice.point(x, 8.2, 9.7), gradient) == doctest::Approx(0.25).epsilon(1e-15));
    CHECK_WITHIN(gradient.norm(), 1e-12);
    CHECK(spline.value(lattice.point(x, 28.2, 9.7)) == doctest::Approx(-0.5).epsilon(1e-15));
  }
  CHECK(spline.value(lattice.point(6.4, 19.5, 9.7)) == doctest::Approx(-0.125).epsilon(1e-12));
  const SplineGrid others[] = {splined(lattice, f), splined(lattice, f, {0.25, -0.5}, 2),
                               splined(lattice, f, {-0.5}, 5)};
  for (int n = 0; n < 2000; ++n) {
    const Vector3 x = inner_point(lattice, random);
    for (const SplineGrid& other : others)
      CHECK_WITHIN(std::abs(spline.value(x) - other.value(x)), 1e-15);  // weights sum to one but for rounding
    if (x.x() > lattice.point(33, 0, 0).x()) {
      CHECK(spline.value(x) == others[0].value(x));
      CHECK(spline.value(x) == others[1].value(x));
    }
  }
  CHECK_FALSE(spline.covers(lattice.point(0.9, 5, 5)));
  CHECK(spline.covers(lattice.point(1.0001, 5, 5)));
  CHECK_FALSE(spline.covers(lattice.point(5, 5, 28.0001)));
  CHECK(spline.covers(lattice.point(5, 5, 27.9999)));
}

}  // namespace glossa::test

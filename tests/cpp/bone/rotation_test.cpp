#include "bone/rotation.hpp"

#include <numbers>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

// Either side of the change from series to closed forms at 0.1, and from nothing to nearly a whole turn.
const std::vector<double> angles{0.0, 1e-160, 1e-12, 1e-5, 0.02, 0.0999999, 0.1, 0.3, 1.1, 2.0, std::numbers::pi, 5.5};

Vector3 random_vector(Random& random) {
  const double x = random(-1.0, 1.0), y = random(-1.0, 1.0);
  return {x, y, random(-1.0, 1.0)};
}

template <class Check>
void for_angles(std::uint64_t seed, Check&& check) {
  Random random(seed);
  for (const double angle : angles)
    for (int k = 0; k < 4; ++k) {
      CAPTURE(angle);
      check(Vector3(angle * random_vector(random).normalized()), random_vector(random));
    }
}

/// Sum of (-1)^k factor(k) s^(2 k - shift) / (2 k + first)!, k from 0.
template <class Factor>
double power_series(double s, int first, int shift, Factor&& factor) {
  long double sum = 0.0L;
  for (int k = 0; k < 25; ++k) {
    if (factor(k) == 0) continue;
    long double term = k % 2 == 0 ? factor(k) : -factor(k);
    for (int n = 2; n <= 2 * k + first; ++n) term /= n;
    sum += term * std::pow(static_cast<long double>(s), 2 * k - shift);
  }
  return static_cast<double>(sum);
}

}  // namespace

TEST_CASE("rotation: the matrix of a rotation vector is a rotation about it") {
  const Vector3 axis = Vector3(1.0, -2.0, 0.5).normalized();
  CHECK_WITHIN((rotation_matrix(0.9 * axis) - rotation()).norm(), 1e-15);
  for_angles(201, [](const Vector3& theta, const Vector3&) {
    const Matrix3 R = rotation_matrix(theta);
    CHECK_WITHIN((R * R.transpose() - Matrix3::Identity()).norm(), 1e-15);
    CHECK_WITHIN(std::abs(R.determinant() - 1.0), 1e-15);
    CHECK_WITHIN((R * theta - theta).norm(), 2e-15);
    CHECK_WITHIN(std::abs(R.trace() - 1.0 - 2.0 * std::cos(theta.norm())), 2e-15);
  });
  CHECK_WITHIN((rotation_matrix(Vector3(0, 0, std::numbers::pi / 2)) * Vector3::UnitX() - Vector3::UnitY()).norm(),
               1e-15);
  CHECK(cross_matrix(Vector3(1, 2, 3)) * Vector3(-2, 5, 7) == Vector3(1, 2, 3).cross(Vector3(-2, 5, 7)));
}

TEST_CASE("rotation: the Jacobian turns a change of the vector into an infinitesimal rotation") {
  for_angles(202, [](const Vector3& theta, const Vector3& d) {
    const Matrix3 change = derivative([&](double h) { return rotation_matrix(theta + h * d); }, 1e-3);
    const Matrix3 expected = cross_matrix(rotation_jacobian(theta) * d) * rotation_matrix(theta);
    CHECK_WITHIN((change - expected).norm(), 5e-12);  // truncation h^4, rounding eps / h
  });
}

TEST_CASE("rotation: the slope of a moment pulled back is the derivative of the Jacobian's transpose") {
  for_angles(203, [](const Vector3& theta, const Vector3& m) {
    const Matrix3 slope = pulled_moment_slope(theta, m);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 column = derivative(
          [&](double h) { return (rotation_jacobian(theta + h * Vector3::Unit(axis)).transpose() * m).eval(); }, 1e-3);
      CHECK_WITHIN((column - slope.col(axis)).norm(), 3e-12);  // truncation h^4, rounding eps / h
    }
  });
}

TEST_CASE("rotation: series and closed forms equal the power series") {
  for (const double s : {1e-8, 1e-3, 0.05, 0.0999999, 0.1, 0.12, 1.0, 3.0}) {
    CAPTURE(s);
    const RotationSeries found(s);
    const auto one = [](int) { return 1; };
    const auto slope = [](int k) { return 2 * k; };
    const double b = power_series(s, 2, 0, one), c = power_series(s, 3, 0, one);
    CHECK_WITHIN(std::abs(found.b / b - 1.0), 5e-14);
    CHECK_WITHIN(std::abs(found.c / c - 1.0), 5e-13);
    CHECK_WITHIN(std::abs(found.b_slope / power_series(s, 2, 2, slope) - 1.0), 1e-10);  // cancellation eps / s^4
    CHECK_WITHIN(std::abs(found.c_slope / power_series(s, 3, 2, slope) - 1.0), 1e-9);
  }
}

}  // namespace glossa::test

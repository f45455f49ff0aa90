#include "material/yeoh_point.hpp"

#include <unsupported/Eigen/AutoDiff>

#include <array>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

using First = Eigen::AutoDiffScalar<Eigen::Matrix<double, 9, 1>>;
using Second = Eigen::AutoDiffScalar<Eigen::Matrix<First, 9, 1>>;

/// Entries of F, column-major, with first and second derivatives with respect to themselves.
std::array<Second, 9> seeded(const Matrix3& F) {
  std::array<Second, 9> result;
  for (Eigen::Index k = 0; k < 9; ++k) {
    Second& x = result[static_cast<std::size_t>(k)];
    x.value() = First(F.reshaped()(k), 9, static_cast<int>(k));
    for (Eigen::Index m = 0; m < 9; ++m) x.derivatives()(m) = First(m == k ? 1.0 : 0.0);
  }
  return result;
}

Second determinant(const std::array<Second, 9>& F) {
  const Second a = F[4] * F[8] - F[5] * F[7], b = F[3] * F[8] - F[5] * F[6], c = F[3] * F[7] - F[4] * F[6];
  return F[0] * a - F[1] * b + F[2] * c;
}

Second isochoric_density(const Yeoh& law, const std::array<Second, 9>& F) {
  Second trace = F[0] * F[0];
  for (std::size_t k = 1; k < 9; ++k) trace += F[k] * F[k];
  const Second logarithm = log(determinant(F));
  const Second scaled = logarithm * First(-2.0 / 3.0);
  const Second power = exp(scaled);
  const Second i1 = trace * power;
  return law.isochoric(i1);
}

Second volumetric_density(const Yeoh& law, const std::array<Second, 9>& F) {
  return law.volumetric(determinant(F));
}

/// Energy, stress and tangent by automatic differentiation.
YeohPoint differentiated(const Second& W) {
  YeohPoint point;
  point.energy = W.value().value();
  for (Eigen::Index k = 0; k < 9; ++k) {
    point.stress.reshaped()(k) = W.value().derivatives()(k);
    point.tangent.col(k) = W.derivatives()(k).derivatives();
  }
  return point;
}

/// A general deformation gradient with the volume ratio J.
Matrix3 deformation(Random& random, double J) {
  Matrix3 F;
  do F = Matrix3::Identity() + random.matrix(0.6);
  while (F.determinant() < 0.1);
  return F * std::cbrt(J / F.determinant());
}

void compare(const YeohPoint& tested, const YeohPoint& oracle, double tolerance) {
  CHECK_WITHIN(std::abs(tested.energy / oracle.energy - 1.0), tolerance);
  CHECK_WITHIN(worst_entry(tested.stress, oracle.stress), tolerance);
  CHECK_WITHIN(worst_entry(tested.tangent, oracle.tangent), 0.5 * tolerance);
  CHECK(tested.tangent != oracle.tangent);
}

const Yeoh tissue{1037.0, 486.0, 1.0369e6};

}  // namespace

TEST_CASE("yeoh: isochoric energy, stress and tangent against automatic differentiation") {
  const Yeoh isochoric{1037.0, 486.0, 0.0};
  Random random(11);
  for (const double J : {0.5, 0.8, 1.0, 1.02, 1.3, 1.6})
    for (int sample = 0; sample < 5; ++sample) {
      const Matrix3 F = deformation(random, J);
      compare(evaluate(isochoric, F), differentiated(isochoric_density(isochoric, seeded(F))), 2e-13);  // rounding
    }
}

TEST_CASE("yeoh: volumetric energy, stress and tangent against automatic differentiation") {
  const Yeoh volumetric{0.0, 0.0, 1.0369e6};
  Random random(12);
  for (const double J : {0.5, 0.8, 1.02, 1.3, 1.6})
    for (int sample = 0; sample < 5; ++sample) {
      const Matrix3 F = deformation(random, J);
      compare(evaluate(volumetric, F), differentiated(volumetric_density(volumetric, seeded(F))), 2e-13);  // rounding
    }
}

TEST_CASE("yeoh: parts add up, and stiffening scales the isochoric one only") {
  Random random(13);
  const Matrix3 F = deformation(random, 1.1);
  const YeohPoint iso = evaluate({1037.0, 486.0, 0.0}, F), vol = evaluate({0.0, 0.0, 1.0369e6}, F);
  const YeohPoint whole = evaluate(tissue, F, 3.7);
  CHECK_WITHIN(std::abs((whole.energy - vol.energy) / (3.7 * iso.energy) - 1.0), 2e-14);
  CHECK_WITHIN(worst_entry((whole.stress - vol.stress).eval(), (3.7 * iso.stress).eval()), 3e-14);
  CHECK_WITHIN(worst_entry((whole.tangent - vol.tangent).eval(), (3.7 * iso.tangent).eval()),
               2e-13);  // kappa / mu times rounding
}

TEST_CASE("yeoh: c20 enters with (I - 3)^2 and slope 2 c20 (I - 3)") {
  const Yeoh law{0.0, 486.0, 0.0};
  CHECK(law.isochoric(5.0) == 486.0 * 4.0);
  CHECK(law.isochoric_slope(5.0) == 2.0 * 486.0 * 2.0);
  CHECK(law.isochoric_curvature() == 2.0 * 486.0);
  CHECK(tissue.isochoric_slope(5.0) == 1037.0 + 4.0 * 486.0);
  CHECK_WITHIN(
      std::abs(slope([&](double h) { return tissue.isochoric(3.4 + h); }, 0.1) / tissue.isochoric_slope(3.4) - 1.0),
      5e-14);
}

TEST_CASE("yeoh: objectivity, W(QF) = W(F) and P(QF) = Q P(F)") {
  Random random(14);
  const Matrix3 F = deformation(random, 0.9), Q = rotation();
  for (const Yeoh& law : {Yeoh{1037.0, 486.0, 0.0}, Yeoh{0.0, 0.0, 1.0369e6}}) {
    const YeohPoint plain = evaluate(law, F), turned = evaluate(law, Q * F);
    CHECK_WITHIN(std::abs(turned.energy / plain.energy - 1.0), 1e-14);
    CHECK_WITHIN(worst_entry(turned.stress, (Q * plain.stress).eval()), 5e-14);
  }
}

TEST_CASE("yeoh: the tangent is symmetric") {
  Random random(15);
  const auto tangent = evaluate(tissue, deformation(random, 1.4)).tangent;
  CHECK_WITHIN(worst_entry(tangent, tangent.transpose().eval()), 1e-15);
}

TEST_CASE("yeoh: rest is free of stress, with the small-strain moduli mu = 2 c10 and kappa") {
  const YeohPoint rest = evaluate(tissue, Matrix3::Identity());
  CHECK(rest.energy == 0.0);
  CHECK(rest.stress.isZero(0.0));
  const auto energy_of = [&](const Matrix3& strain) {
    const Vector e = strain.reshaped();
    return e.dot(rest.tangent * e);
  };
  Matrix3 shear = Matrix3::Zero();
  shear(0, 1) = shear(1, 0) = 0.5;
  CHECK_WITHIN(std::abs(energy_of(shear) / (2.0 * 1037.0) - 1.0), 1e-15);                // mu gamma^2
  CHECK_WITHIN(std::abs(energy_of(Matrix3::Identity() / 3.0) / 1.0369e6 - 1.0), 1e-15);  // kappa (tr e)^2
  CHECK_WITHIN(std::abs(energy_of(Vector3(1, -1, 0).asDiagonal()) / (4.0 * 2.0 * 1037.0) - 1.0), 1e-15);  // 2 mu e:e
  Matrix3 spin = Matrix3::Zero();
  spin(0, 1) = 1.0;
  spin(1, 0) = -1.0;
  CHECK_WITHIN(std::abs(energy_of(spin)) / 2074.0, 1e-15);
}

TEST_CASE("yeoh: a deformation gradient that is not positive is refused") {
  Matrix3 mirror = Matrix3::Identity();
  mirror(2, 2) = -1.0;
  CHECK_THROWS_WITH_AS((void)evaluate(tissue, mirror),
                       "deformation gradient: its determinant must be positive, it is -1.000000", InputError);
  CHECK_THROWS_AS((void)evaluate(tissue, Matrix3::Zero()), InputError);
}

}  // namespace glossa::test

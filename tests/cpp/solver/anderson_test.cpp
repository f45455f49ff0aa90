#include "solver/anderson.hpp"

#include "../fixture.hpp"

namespace glossa::test {
namespace {

Eigen::MatrixXd random_spd(Eigen::Index n, std::uint64_t seed, double spread) {
  Random random(seed);
  Eigen::MatrixXd M(n, n);
  for (double& x : M.reshaped()) x = random(-1, 1);
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(M).householderQ();
  Vector eigenvalues(n);
  for (Eigen::Index k = 0; k < n; ++k)
    eigenvalues(k) = std::pow(spread, static_cast<double>(k) / static_cast<double>(n - 1));
  return Q * eigenvalues.asDiagonal() * Q.transpose();
}

/// Residual norms of u <- u + increment for G(u) = 0 with the preconditioner P.
template <class Residual>
std::vector<double> history(Residual&& G, const Eigen::MatrixXd& P, int steps, bool accelerated,
                            std::size_t memory = 8) {
  Anderson anderson(memory);
  const Eigen::LLT<Eigen::MatrixXd> factor(P);
  Vector u = Vector::Zero(P.rows());
  std::vector<double> norms;
  for (int k = 0; k < steps; ++k) {
    const Vector g = G(u), F = -factor.solve(g);
    norms.push_back(g.norm());
    u += accelerated ? anderson.increment(u, F, g) : F;
  }
  return norms;
}

}  // namespace

TEST_CASE("anderson: a linear system of n unknowns in n steps, with a poor preconditioner") {
  constexpr Eigen::Index n = 7;
  const Eigen::MatrixXd A = random_spd(n, 101, 50.0), P = random_spd(n, 102, 3.0);
  const Vector b = Vector::Ones(n);
  const auto residual = [&](const Vector& u) -> Vector { return A * u - b; };
  const std::vector<double> norms = history(residual, P, n + 2, true);
  CHECK(norms[n - 2] > 1e-6 * norms[0]);
  CHECK_WITHIN(norms[n + 1] / norms[0], 1e-12);                 // rounding times the condition of the Gram matrix
  CHECK(history(residual, P, n + 2, false)[n + 1] > norms[0]);  // the plain iteration diverges
}

TEST_CASE("anderson: a nonlinear system faster than the plain fixed point") {
  constexpr Eigen::Index n = 30;
  const Eigen::MatrixXd A = random_spd(n, 103, 4.0), P = 3.0 * Eigen::MatrixXd::Identity(n, n);
  const auto residual = [&](const Vector& u) -> Vector {
    return A * u + 0.3 * u.array().cube().matrix() - Vector::Ones(n);
  };
  const auto iterations = [&](bool accelerated) {
    const std::vector<double> norms = history(residual, P, 100, accelerated);
    int k = 0;
    while (k < 100 && norms[static_cast<std::size_t>(k)] > 1e-10 * norms[0]) ++k;
    return k;
  };
  CHECK(iterations(true) < 25);
  CHECK(iterations(false) > 2 * iterations(true));
}

TEST_CASE("anderson: the first step, and the one after a reset, is the plain one") {
  Anderson anderson;
  const Vector u = Vector::Zero(2), F{{1.0, 2.0}}, G{{-1.0, -2.0}};
  CHECK(anderson.increment(u, F, G) == F);
  CHECK(anderson.increment(F, 0.5 * F, 0.5 * G) != 0.5 * F);
  anderson.reset();
  CHECK(anderson.increment(u, F, G) == F);
}

}  // namespace glossa::test

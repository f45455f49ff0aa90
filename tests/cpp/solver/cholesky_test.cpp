#include "solver/cholesky.hpp"

#include <algorithm>
#include <cmath>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

/// A random symmetric matrix of n rows with about six entries in each, diagonally dominant by `margin`.
LowerColumns random_sparse(Index n, double margin) {
  Random random(91);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  for (Index k = 0; k < 3 * n; ++k) {
    const auto i = static_cast<Eigen::Index>(random(0, n)), j = static_cast<Eigen::Index>(random(0, n));
    A(i, j) = A(j, i) = random(-1, 1);
  }
  for (Index j = 0; j < n; ++j) {
    A(j, j) = 0.0;
    A(j, j) = A.col(j).cwiseAbs().sum() + margin;
  }
  LowerColumns columns;
  columns.column_start.push_back(0);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i)
      if (A(i, j) != 0.0) {
        columns.row.push_back(i);
        columns.value.push_back(A(i, j));
      }
    columns.column_start.push_back(static_cast<Index>(columns.row.size()));
  }
  return columns;
}

double backward_error(Cholesky& factor, const LowerColumns& columns) {
  const Eigen::MatrixXd A = dense(columns);
  Vector x = as_vector(Random(92).field(static_cast<std::size_t>(A.rows()), 1.0));
  const Vector b = x;
  factor.solve(x);
  return (A * x - b).cwiseAbs().maxCoeff() / (A.cwiseAbs().rowwise().sum().maxCoeff() * x.cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("cholesky: solves a random sparse system to rounding") {
  const LowerColumns columns = random_sparse(300, 0.1);
  Cholesky factor(columns);
  REQUIRE(factor.factorise(columns));
  CHECK_WITHIN(backward_error(factor, columns), 1e-15);
  CHECK(factor.factor_entries() >= static_cast<double>(columns.row.size()));
  CHECK(factor.factor_flops() > factor.factor_entries());
}

TEST_CASE("cholesky: the rough solve is the exact one to single precision, after every factorisation") {
  LowerColumns columns = random_sparse(300, 0.1);
  Cholesky factor(columns);
  for (const double scale : {1.0, 3.0}) {
    for (double& value : columns.value) value *= scale;
    REQUIRE(factor.factorise(columns));
    Vector exact = as_vector(Random(94).field(300, 1.0)), rough = exact;
    factor.solve(exact);
    factor.solve_roughly(rough);
    CHECK_WITHIN(worst_entry(rough, exact), 5e-6);  // 2^-24 times the condition
    CHECK(rough != exact);
  }
}

TEST_CASE("cholesky: a matrix with a value that is not a number is reported") {
  LowerColumns columns = random_sparse(120, 0.1);
  Cholesky factor(columns);
  columns.value[columns.value.size() / 2] = std::nan("");
  CHECK_FALSE(factor.factorise(columns));
}

TEST_CASE("cholesky: an indefinite matrix is reported, and the object serves again") {
  const LowerColumns good = random_sparse(120, 0.1);
  LowerColumns bad = good;
  bad.value[static_cast<std::size_t>(bad.column_start[100])] = -3.0;
  Cholesky factor(good);
  for (int round = 0; round < 2; ++round) {
    REQUIRE(factor.factorise(good));
    CHECK_FALSE(factor.factorise(bad));
  }
  REQUIRE(factor.factorise(good));
  CHECK_WITHIN(backward_error(factor, good), 1e-15);
}

// A chain of springs with one soft link: positive definite by 1e-9 of its stiffness, below the rounding of floats.
TEST_CASE("cholesky: what single precision cannot factorise or solve is done in double") {
  constexpr Index n = 200;
  LowerColumns chain{{0}, {}, {}};
  for (Index j = 0; j < n; ++j) {
    chain.row.push_back(j);
    chain.value.push_back(j == 0 ? 1.0 + 1e-9 : j == n - 1 ? 1.0 : 2.0);
    if (j + 1 < n) {
      chain.row.push_back(j + 1);
      chain.value.push_back(-1.0);
    }
    chain.column_start.push_back(static_cast<Index>(chain.row.size()));
  }
  Cholesky factor(chain);
  REQUIRE(factor.factorise(chain));
  CHECK_WITHIN(backward_error(factor, chain), 1e-14);
}

TEST_CASE("cholesky: a loose tolerance leaves a residual within it") {
  const LowerColumns columns = random_sparse(300, 0.1);
  Cholesky factor(columns);
  REQUIRE(factor.factorise(columns));
  const Vector right = as_vector(Random(95).field(300, 1.0));
  Vector x = right;
  factor.solve(x, 1e-3);
  const double left = (dense(columns) * x - right).norm() / right.norm();
  CHECK(left < 1e-3);
  CHECK(left > 1e-15);
}

TEST_CASE("cholesky: moved objects keep their factor") {
  const LowerColumns columns = random_sparse(60, 0.1);
  Cholesky first(columns);
  REQUIRE(first.factorise(columns));
  Cholesky second(std::move(first));
  CHECK_WITHIN(backward_error(second, columns), 1e-15);
}

TEST_CASE("cholesky: the fill-reducing order is a permutation and reduces fill") {
  // A grid of 20 x 20 nodes in a random numbering.
  constexpr Index side = 20, n = side * side;
  std::vector<Index> number = natural_order(std::vector<Index>(n + 1), {});
  Random random(93);
  for (std::size_t k = n - 1; k > 0; --k)
    std::swap(number[k], number[static_cast<std::size_t>(random(0, static_cast<double>(k + 1)))]);
  std::vector<std::vector<Index>> lower(n);
  const auto join = [&](Index a, Index b) {
    const auto [low, high] = std::minmax(number[static_cast<std::size_t>(a)], number[static_cast<std::size_t>(b)]);
    lower[static_cast<std::size_t>(low)].push_back(high);
  };
  for (Index a = 0; a < n; ++a) {
    join(a, a);
    if (a % side + 1 < side) join(a, a + 1);
    if (a + side < n) join(a, a + side);
  }
  LowerColumns graph{{0}, {}, {}};
  for (auto& column : lower) {
    std::sort(column.begin(), column.end());
    graph.row.insert(graph.row.end(), column.begin(), column.end());
    graph.column_start.push_back(static_cast<Index>(graph.row.size()));
  }
  graph.value.assign(graph.row.size(), 1.0);
  const std::vector<Index> order = fill_reducing_order(graph.column_start, graph.row);
  std::vector<Index> sorted = order, place(n);
  std::sort(sorted.begin(), sorted.end());
  CHECK(sorted == natural_order(graph.column_start, {}));

  for (std::size_t k = 0; k < n; ++k) place[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  std::vector<std::vector<Index>> ordered(n);
  for (std::size_t j = 0; j < n; ++j)
    for (Index k = graph.column_start[j]; k < graph.column_start[j + 1]; ++k) {
      const auto [low, high] =
          std::minmax(place[j], place[static_cast<std::size_t>(graph.row[static_cast<std::size_t>(k)])]);
      ordered[static_cast<std::size_t>(low)].push_back(high);
    }
  LowerColumns reordered{{0}, {}, graph.value};
  for (auto& column : ordered) {
    std::sort(column.begin(), column.end());
    reordered.row.insert(reordered.row.end(), column.begin(), column.end());
    reordered.column_start.push_back(static_cast<Index>(reordered.row.size()));
  }
  CHECK(Cholesky(reordered).factor_entries() < 0.4 * Cholesky(graph).factor_entries());
}

}  // namespace glossa::test

#include "solver/single_factor.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "../fixture.hpp"
#include "solver/cholesky.hpp"

namespace glossa::test {
namespace {

/// Laplacian of a grid of side x side nodes with `each` unknowns coupled densely at a node, in a fill-reducing order.
LowerColumns grid(Index side, Index each) {
  const Index n = side * side;
  const auto neighbours = [&](Index a, Index b) {
    return std::abs(a / side - b / side) <= 1 && std::abs(a % side - b % side) <= 1;
  };
  std::vector<Index> start{0}, row;
  for (Index a = 0; a < n; ++a) {
    for (Index b = a; b < n; ++b)
      if (neighbours(a, b)) row.push_back(b);
    start.push_back(static_cast<Index>(row.size()));
  }
  const std::vector<Index> order = fill_reducing_order(start, row);
  LowerColumns columns{{0}, {}, {}};
  Random random(17);
  for (Index j = 0; j < n * each; ++j) {
    for (Index i = j; i < n * each; ++i) {
      const Index a = order[static_cast<std::size_t>(j / each)], b = order[static_cast<std::size_t>(i / each)];
      if (!neighbours(a, b)) continue;
      columns.row.push_back(i);
      columns.value.push_back(i == j ? 9.5 * each : random(-1.0, 0.0));
    }
    columns.column_start.push_back(static_cast<Index>(columns.row.size()));
  }
  return columns;
}

double error_of_rough_solve(const LowerColumns& columns, int threads) {
  Cholesky factor(columns);
  REQUIRE(factor.factorise(columns, threads));
  const Vector right = as_vector(Random(18).field(columns.column_start.size() - 1, 1.0));
  Vector x = right;
  factor.solve_roughly(x);
  const Eigen::MatrixXd A = dense(columns);
  return (A * x - right).norm() / right.norm();
}

}  // namespace

TEST_CASE("single factor: fronts of many sizes add up to the matrix") {
  CHECK_WITHIN(error_of_rough_solve(grid(12, 3), 1), 2e-6);
  CHECK_WITHIN(error_of_rough_solve(grid(25, 1), 1), 2e-6);
}

TEST_CASE("single factor: supernodes wider than a panel, and steps that are cut in two") {
  CHECK_WITHIN(error_of_rough_solve(grid(2, 150), 1), 2e-6);
  CHECK_WITHIN(error_of_rough_solve(grid(7, 24), 1), 2e-6);
}

TEST_CASE("single factor: the same bits on any number of threads") {
  for (const LowerColumns& columns : {grid(12, 3), grid(7, 24), grid(2, 150)}) {
    std::vector<Vector> solutions;
    for (const int threads : {1, 2, 3}) {
      Cholesky factor(columns);
      REQUIRE(factor.factorise(columns, threads));
      Vector x = as_vector(Random(19).field(columns.column_start.size() - 1, 1.0));
      factor.solve_roughly(x);
      solutions.push_back(std::move(x));
    }
    CHECK(solutions[1] == solutions[0]);
    CHECK(solutions[2] == solutions[0]);
  }
}

TEST_CASE("single factor: serves again after a matrix that is not positive definite") {
  const LowerColumns good = grid(12, 3);
  LowerColumns bad = good;
  bad.value[static_cast<std::size_t>(bad.column_start[200])] = -1.0;
  Cholesky factor(good);
  Vector first = as_vector(Random(20).field(good.column_start.size() - 1, 1.0)), second = first;
  REQUIRE(factor.factorise(good, 2));
  factor.solve_roughly(first);
  CHECK_FALSE(factor.factorise(bad, 2));
  REQUIRE(factor.factorise(good, 2));
  factor.solve_roughly(second);
  CHECK(first == second);
}

}  // namespace glossa::test

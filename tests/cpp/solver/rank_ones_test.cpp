#include "solver/rank_ones.hpp"

#include "../fixture.hpp"
#include "solver/cholesky.hpp"

namespace glossa::test {
namespace {

/// A chain of springs to ground, n unknowns.
LowerColumns chain(Index n) {
  LowerColumns columns{{0}, {}, {}};
  for (Index j = 0; j < n; ++j) {
    columns.row.push_back(j);
    columns.value.push_back(2.5);
    if (j + 1 < n) {
      columns.row.push_back(j + 1);
      columns.value.push_back(-1.0);
    }
    columns.column_start.push_back(static_cast<Index>(columns.row.size()));
  }
  return columns;
}

/// Two terms that share an unknown.
RankOnes two_terms() {
  RankOnes terms;
  terms.row = {3, 20, 41};
  terms.value = {1.0, -0.5, 0.25};
  terms.close(4.0);
  terms.row.insert(terms.row.end(), {20, 55});
  terms.value.insert(terms.value.end(), {1.0, 1.0});
  terms.close(9.0);
  return terms;
}

Eigen::MatrixXd dense(const RankOnes& terms, Eigen::Index n) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t k = 0; k < terms.weight.size(); ++k) {
    Vector g = Vector::Zero(n);
    for (auto e = static_cast<std::size_t>(terms.start[k]); e < static_cast<std::size_t>(terms.start[k + 1]); ++e)
      g(terms.row[e]) = terms.value[e];
    sum += terms.weight[k] * g * g.transpose();
  }
  return sum;
}

}  // namespace

TEST_CASE("rank ones: their product is that of the sum of weight g g'") {
  const RankOnes terms = two_terms();
  const Vector x = as_vector(Random(5).field(60, 1.0));
  Vector product = Vector::Constant(60, 2.0);
  terms.add_product(x, product);
  CHECK_WITHIN(worst_entry(product, Vector(Vector::Constant(60, 2.0) + dense(terms, 60) * x)), 1e-14);
}

TEST_CASE("rank ones: a solve with the factor of the rest is that of the whole matrix") {
  const LowerColumns columns = chain(60);
  const RankOnes terms = two_terms();
  Cholesky factor(columns);
  REQUIRE(factor.factorise(columns));
  const Eigen::MatrixXd whole = test::dense(columns) + dense(terms, 60);
  const Vector right = as_vector(Random(6).field(60, 1.0));
  for (const double tolerance : {1e-2, 1e-14}) {
    Vector x = right;
    factor.solve(x, tolerance, terms);
    CHECK((whole * x - right).norm() <= 1.1 * tolerance * right.norm());
  }
}

}  // namespace glossa::test

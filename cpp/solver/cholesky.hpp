// Sparse Cholesky factors, supernodal: analysed by CHOLMOD (Chen, Davis, Hager & Rajamanickam 2008), computed in
// single precision by solver/single_factor.hpp and, where that is too rough, in double precision by CHOLMOD.
#pragma once

#include <memory>
#include <vector>

#include "effect/block_matrix.hpp"
#include "solver/rank_ones.hpp"

namespace glossa {

/// Fill-reducing order of a graph given as the lower triangle of a symmetric pattern; postordered.
std::vector<Index> fill_reducing_order(const std::vector<Index>& column_start, const std::vector<Index>& row);

/// One symbolic analysis, many numeric factorisations, many solves. BLAS runs on one thread inside.
class Cholesky {
 public:
  /// Analyses the pattern of `matrix`, which must already be in elimination order.
  explicit Cholesky(const LowerColumns& matrix);
  ~Cholesky();
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;

  /// Factorises in single precision on up to `threads` threads. Where rounding makes the matrix indefinite, in double
  /// precision, or, if that is dear, with a slightly enlarged diagonal. False if it is not positive definite (the
  /// previous factor is lost then). The matrix must stay as it is while solve() is used.
  [[nodiscard]] bool factorise(const LowerColumns& matrix, int threads = 1);
  /// Replaces `x` by the solution of A x = b, x = b on entry, to a residual of `tolerance` |b| or what rounding in
  /// double precision allows: with a factor in single precision by conjugate gradients. Needs a successful
  /// factorisation; makes one in double precision where the single one is too rough.
  void solve(Vector& x, double tolerance = 1e-15);
  /// The same for A + `more`, by conjugate gradients with the factor of A; ends short of the tolerance where that
  /// takes more than some dozens of iterations.
  void solve(Vector& x, double tolerance, const RankOnes& more);
  /// With the factor in single precision alone, for preconditioning.
  void solve_roughly(Vector& x);

  /// Entries of the factor and floating-point operations of one factorisation.
  [[nodiscard]] double factor_entries() const;
  [[nodiscard]] double factor_flops() const;

 private:
  [[nodiscard]] bool factorise_exactly();
  [[nodiscard]] bool iterate(Vector& x, double tolerance, int most, const RankOnes* more);
  void solve_exactly(Vector& x);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glossa

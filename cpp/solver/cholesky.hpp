// Sparse Cholesky factors through CHOLMOD (Chen, Davis, Hager & Rajamanickam 2008), supernodal.
#pragma once

#include <memory>
#include <vector>

#include "effect/block_matrix.hpp"

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

  /// Factorises; false if the matrix is not positive definite (the previous factor is lost then).
  [[nodiscard]] bool factorise(const LowerColumns& matrix);
  /// Replaces `x` by the solution of A x = b, x = b on entry. Needs a successful factorisation.
  void solve(Vector& x) const;
  /// As solve, with the factor in single precision: for preconditioning. Half the time, seven digits.
  void solve_roughly(Vector& x);

  /// Entries of the factor and floating-point operations of one factorisation.
  [[nodiscard]] double factor_entries() const;
  [[nodiscard]] double factor_flops() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glossa

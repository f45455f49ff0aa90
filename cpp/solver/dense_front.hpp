// Dense steps of a factorisation in single precision, on column-major blocks; BLAS and LAPACK behind them.
//
// Large steps are always cut into the same two parts, whatever the number of threads, so that the bits do not depend
// on it.
#pragma once

#include "core/index.hpp"

namespace glossa {

/// A block of a column-major matrix.
struct Block {
  float* data;
  Index lead;
};

/// The lower triangle of the n x n block becomes its Cholesky factor; false if it is not positive definite.
[[nodiscard]] bool factorise_dense(Block a, Index n);
/// x <- x L^-T for `rows` x n, L the lower triangle of the n x n block.
void divide_dense(Block triangle, Index n, Block x, Index rows, int threads);
/// The lower triangle of the n x n block u <- keep * u - x x', x of n rows and k columns.
void subtract_square(Block x, Index n, Index k, Block u, float keep, int threads);
/// u <- u - x y' with x of `rows` rows, y of `columns` rows and both of k columns.
void subtract_product(Block x, Index rows, Block y, Index columns, Index k, Block u, int threads);

}  // namespace glossa

// Blocks of columns of a single-precision factor, as the triangular kernels see them.
#pragma once

#include <cstddef>

#include "core/index.hpp"

namespace glossa {

/// Consecutive columns of the factor with the same rows below them. Columns are padded with zeros to packs of eight.
struct Supernode {
  Index first;  ///< first column
  Index columns;
  Index below;           ///< rows below the diagonal block
  Index padded_columns;  ///< leading dimension of the diagonal block
  Index padded_below;    ///< leading dimension of the part below
  Index row_start;       ///< of those rows
  std::size_t diagonal;  ///< values of the diagonal block: lower triangle, diagonal inverted
  std::size_t off;       ///< values of the part below
};

/// A factor and two work columns.
struct SingleFactorView {
  const Supernode* supernodes;
  std::size_t count;
  const Index* rows;
  const float* values;
  float* block;
  float* below;
};

// Replace x by the solution of L L' x = b, one function for each instruction set.
namespace baseline {
void solve_single(const SingleFactorView& factor, float* x);
}
namespace avx2 {
void solve_single(const SingleFactorView& factor, float* x);
}

}  // namespace glossa

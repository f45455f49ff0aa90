// Compiled once for each instruction set, with GLOSSA_KERNEL naming it.
#include "core/pack.hpp"
#include "solver/supernode.hpp"

#ifndef GLOSSA_KERNEL
#error "GLOSSA_KERNEL must name the instruction set"
#endif

namespace glossa::GLOSSA_KERNEL {
namespace {

typedef float Eight __attribute__((vector_size(32)));
typedef float LooseEight __attribute__((vector_size(32), aligned(4), may_alias));
constexpr int width = 8;

GLOSSA_ALWAYS_INLINE Eight load(const float* from) {
  return *reinterpret_cast<const LooseEight*>(from);
}
GLOSSA_ALWAYS_INLINE void store(float* to, Eight value) {
  *reinterpret_cast<LooseEight*>(to) = value;
}
GLOSSA_ALWAYS_INLINE float sum(Eight v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

// to += a0 c0 + a1 c1 + a2 c2 + a3 c3 over n (a multiple of 8) entries.
GLOSSA_ALWAYS_INLINE void add_four(float* to, const float* column, Index lead, const float* a, Index n) {
  const float a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
  const float *c0 = column, *c1 = c0 + lead, *c2 = c1 + lead, *c3 = c2 + lead;
  for (Index i = 0; i < n; i += width)
    store(to + i, load(to + i) + (a0 * load(c0 + i) + a1 * load(c1 + i)) + (a2 * load(c2 + i) + a3 * load(c3 + i)));
}
GLOSSA_ALWAYS_INLINE void add_one(float* to, const float* column, float a, Index n) {
  for (Index i = 0; i < n; i += width) store(to + i, load(to + i) + a * load(column + i));
}

GLOSSA_ALWAYS_INLINE const float* column_of(const float* first, Index j, Index lead) {
  return first + static_cast<std::size_t>(j) * static_cast<std::size_t>(lead);
}

// L y = b for one supernode, and its share of the rows below.
void eliminate(const SingleFactorView& factor, const Supernode& s, float* x) {
  const float* diagonal = factor.values + s.diagonal;
  const float* off = factor.values + s.off;
  const Index* rows = factor.rows + s.row_start;
  float *block = factor.block, *below = factor.below;
  for (Index j = 0; j < s.padded_columns; ++j) block[j] = j < s.columns ? x[s.first + j] : 0.0f;
  for (Index j = 0; j < s.columns; ++j) {
    const float* column = column_of(diagonal, j, s.padded_columns);
    const float y = block[j] * column[j];
    const Index from = (j + 1) / width * width;  // above the diagonal the pack holds zeros
    add_one(block + from, column + from, -y, s.padded_columns - from);
    block[j] = y;
  }
  for (Index j = 0; j < s.columns; ++j) x[s.first + j] = block[j];
  for (Index i = 0; i < s.padded_below; ++i) below[i] = 0.0f;
  Index j = 0;
  for (; j + 4 <= s.columns; j += 4)
    add_four(below, column_of(off, j, s.padded_below), s.padded_below, block + j, s.padded_below);
  for (; j < s.columns; ++j) add_one(below, column_of(off, j, s.padded_below), block[j], s.padded_below);
  for (Index i = 0; i < s.below; ++i) x[rows[i]] -= below[i];
}

// L' x = y for one supernode.
void substitute(const SingleFactorView& factor, const Supernode& s, float* x) {
  const float* diagonal = factor.values + s.diagonal;
  const float* off = factor.values + s.off;
  const Index* rows = factor.rows + s.row_start;
  float *block = factor.block, *below = factor.below;
  for (Index i = 0; i < s.padded_below; ++i) below[i] = i < s.below ? x[rows[i]] : 0.0f;
  for (Index j = 0; j < s.padded_columns; ++j) block[j] = j < s.columns ? x[s.first + j] : 0.0f;
  Index j = 0;
  for (; j + 4 <= s.columns; j += 4) {
    const float *c0 = column_of(off, j, s.padded_below), *c1 = c0 + s.padded_below, *c2 = c1 + s.padded_below,
                *c3 = c2 + s.padded_below;
    Eight d0{}, d1{}, d2{}, d3{};
    for (Index i = 0; i < s.padded_below; i += width) {
      const Eight b = load(below + i);
      d0 += b * load(c0 + i);
      d1 += b * load(c1 + i);
      d2 += b * load(c2 + i);
      d3 += b * load(c3 + i);
    }
    block[j] -= sum(d0);
    block[j + 1] -= sum(d1);
    block[j + 2] -= sum(d2);
    block[j + 3] -= sum(d3);
  }
  for (; j < s.columns; ++j) {
    const float* column = column_of(off, j, s.padded_below);
    Eight d{};
    for (Index i = 0; i < s.padded_below; i += width) d += load(below + i) * load(column + i);
    block[j] -= sum(d);
  }
  for (j = s.columns - 1; j >= 0; --j) {
    const float* column = column_of(diagonal, j, s.padded_columns);
    const float right = block[j];
    block[j] = 0.0f;  // its pack may hold the inverted diagonal
    Eight d{};
    for (Index i = (j + 1) / width * width; i < s.padded_columns; i += width) d += load(column + i) * load(block + i);
    block[j] = (right - sum(d)) * column[j];
    x[s.first + j] = block[j];
  }
}

}  // namespace

void solve_single(const SingleFactorView& factor, float* x) {
  for (std::size_t k = 0; k < factor.count; ++k) eliminate(factor, factor.supernodes[k], x);
  for (std::size_t k = factor.count; k-- > 0;) substitute(factor, factor.supernodes[k], x);
}

}  // namespace glossa::GLOSSA_KERNEL

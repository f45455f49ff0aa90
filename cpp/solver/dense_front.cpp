#include "solver/dense_front.hpp"

#include <cmath>

#include "core/parallel.hpp"

extern "C" {
void spotrf_(const char*, const int*, float*, const int*, int*);
void strsm_(const char*, const char*, const char*, const char*, const int*, const int*, const float*, const float*,
            const int*, float*, const int*);
void ssyrk_(const char*, const char*, const int*, const int*, const float*, const float*, const int*, const float*,
            float*, const int*);
void sgemm_(const char*, const char*, const int*, const int*, const int*, const float*, const float*, const int*,
            const float*, const int*, const float*, float*, const int*);
}

namespace glossa {
namespace {

constexpr double worth_cutting = 2e6;  // multiplications of a step

Block right_of(Block b, Index columns) {
  return {b.data + static_cast<std::ptrdiff_t>(columns) * b.lead, b.lead};
}
Block below(Block b, Index rows) {
  return {b.data + rows, b.lead};
}

// Runs both, on two threads if there are two.
template <class First, class Second>
void both(int threads, const First& first, const Second& second) {
  parallel_items(2, threads, [&](int item) { item == 0 ? first() : second(); });
}

void divide(Block triangle, Index n, Block x, Index rows) {
  const float one = 1.0f;
  strsm_("R", "L", "T", "N", &rows, &n, &one, triangle.data, &triangle.lead, x.data, &x.lead);
}

void square(Block x, Index n, Index k, Block u, float keep) {
  const float minus = -1.0f;
  ssyrk_("L", "N", &n, &k, &minus, x.data, &x.lead, &keep, u.data, &u.lead);
}

void product(Block x, Index rows, Block y, Index columns, Index k, Block u, float keep) {
  const float minus = -1.0f;
  sgemm_("N", "T", &rows, &columns, &k, &minus, x.data, &x.lead, y.data, &y.lead, &keep, u.data, &u.lead);
}

}  // namespace

bool factorise_dense(Block a, Index n) {
  int info = 0;
  spotrf_("L", &n, a.data, &a.lead, &info);
  return info == 0;
}

void divide_dense(Block triangle, Index n, Block x, Index rows, int threads) {
  if (rows == 0) return;
  if (static_cast<double>(rows) * n * n < worth_cutting) {
    divide(triangle, n, x, rows);
    return;
  }
  const Index half = rows / 2;
  both(
      threads, [&] { divide(triangle, n, x, half); }, [&] { divide(triangle, n, below(x, half), rows - half); });
}

void subtract_square(Block x, Index n, Index k, Block u, float keep, int threads) {
  if (n == 0) return;
  if (static_cast<double>(n) * n * k < worth_cutting) {
    square(x, n, k, u, keep);
    return;
  }
  const auto cut = static_cast<Index>((1.0 - std::sqrt(0.5)) * n);  // equal areas
  const Block rest = below(x, cut);
  both(
      threads,
      [&] {
        square(x, cut, k, u, keep);
        product(rest, n - cut, x, cut, k, below(u, cut), keep);
      },
      [&] { square(rest, n - cut, k, right_of(below(u, cut), cut), keep); });
}

void subtract_product(Block x, Index rows, Block y, Index columns, Index k, Block u, int threads) {
  if (rows == 0 || columns == 0) return;
  if (static_cast<double>(rows) * columns * k < worth_cutting) {
    product(x, rows, y, columns, k, u, 1.0f);
    return;
  }
  const Index half = rows / 2;
  both(
      threads, [&] { product(x, half, y, columns, k, u, 1.0f); },
      [&] { product(below(x, half), rows - half, y, columns, k, below(u, half), 1.0f); });
}

}  // namespace glossa

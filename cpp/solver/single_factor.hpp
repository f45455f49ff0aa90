// A Cholesky factor in single precision, for use as a preconditioner.
//
// A triangular solve reads every entry of the factor twice and does little else, so halving the entries nearly halves
// its time. The rounding (6e-8 times the spread of stiffness, well below 1e-2 here) only matters where a single solve
// must be exact; the quasi-Newton iterations that use this one correct it with the residual, which stays in double
// precision.
#pragma once

#include <vector>

#include "core/types.hpp"
#include "solver/supernode.hpp"

namespace glossa {

class SingleFactor {
 public:
  /// Copies a supernodal factor: `super` first columns (one more than supernodes), `row_start` and `rows` all rows of
  /// each supernode, `value_start` and `values` column-major blocks over these rows.
  void copy(std::size_t count, const Index* super, const Index* row_start, const Index* rows, const Index* value_start,
            const double* values);
  /// Replaces x by the solution of L L' x = b.
  void solve(Vector& x);

 private:
  std::vector<Supernode> supernodes_;
  std::vector<Index> rows_;
  std::vector<float> values_, work_, x_;
};

}  // namespace glossa

// A Cholesky factor in single precision.
//
// Half the bytes and twice the numbers in a register: a factorisation takes less than half the time of one in double
// precision, a triangular solve, which reads every entry twice and does little else, about half. The rounding (6e-8
// times the spread of stiffness, seldom above 1e-2 here) only matters where a single solve must be exact; iterations
// that use this factor correct it with residuals in double precision.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "core/types.hpp"
#include "solver/dense_front.hpp"
#include "solver/supernodal_layout.hpp"

namespace glossa {

class SingleFactor {
 public:
  explicit SingleFactor(SupernodalLayout layout);

  /// Factorises a matrix of the layout's pattern, subtree by subtree on up to `threads` threads with the same bits for
  /// any number, its diagonal enlarged by this share; false if rounding to single precision leaves it not positive
  /// definite.
  [[nodiscard]] bool factorise(const LowerColumns& matrix, int threads, float share = 0.0f);
  /// Takes over a factor in double precision with the same supernodes: blocks of all rows, column by column.
  void copy(const Index* value_start, const double* values);
  /// Replaces x by the solution of L L' x = b.
  void solve(Vector& x);

 private:
  // What a front passes on to its parent: a square of its rows below, lower triangle.
  using Update = std::vector<float>;
  // Updates that are done with, for use again.
  struct Pool {
    std::mutex mutex;
    std::vector<std::unique_ptr<Update>> free;
  };
  [[nodiscard]] bool eliminate(Index k, const LowerColumns& matrix, int threads, float share);
  [[nodiscard]] bool factorise_columns(const Supernode& s, int threads);
  void add_to_columns(Index child, const Supernode& s);
  void add_to_update(Index child, const Supernode& s, Update& update) const;
  [[nodiscard]] std::unique_ptr<Update> take(std::size_t size);
  void give_back(std::unique_ptr<Update> update);
  [[nodiscard]] Block diagonal(const Supernode& s, Index row, Index column) {
    return {values_.data() + s.diagonal + column * static_cast<std::ptrdiff_t>(s.padded_columns) + row,
            s.padded_columns};
  }
  [[nodiscard]] Block off(const Supernode& s, Index column) {
    return {values_.data() + s.off + column * static_cast<std::ptrdiff_t>(s.padded_below), s.padded_below};
  }

  SupernodalLayout layout_;
  std::vector<float> values_, work_, x_;
  std::vector<std::unique_ptr<Update>> updates_;  // of each supernode, until its parent has taken it
  std::unique_ptr<Pool> pool_ = std::make_unique<Pool>();
};

}  // namespace glossa

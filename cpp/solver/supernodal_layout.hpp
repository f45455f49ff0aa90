// Where the entries of a supernodal Cholesky factor lie, and the order and independence of its fronts: everything of
// a multifrontal factorisation (Duff & Reid 1983; Liu 1992) that depends on the pattern alone.
#pragma once

#include <vector>

#include "core/types.hpp"
#include "effect/block_matrix.hpp"
#include "solver/supernode.hpp"

namespace glossa {

/// A front is a supernode with the rows below it; it passes what it leaves of those rows on to its parent.
struct SupernodalLayout {
  std::vector<Supernode> supernodes;
  std::vector<Index> rows;            ///< below each supernode, ascending
  std::vector<Index> place_in_next;   ///< of each of these rows in the parent's columns and rows below
  std::vector<Index> passed_columns;  ///< of each supernode: how many of its rows below are columns of the parent
  Rows<Index> children;               ///< of each supernode, ascending
  std::vector<std::size_t> entry;     ///< place of each matrix entry among the values of the factor
  std::vector<std::vector<Index>> branches;  ///< disjoint subtrees, each in order of elimination
  std::vector<Index> trunk;                  ///< the supernodes above them, in order of elimination
  std::size_t value_count = 0;
  Index longest = 0;  ///< padded rows of a supernode

  /// `super`: first columns (one more than supernodes); `row_start` and `row`: all rows of each supernode. The entries
  /// of `matrix` must lie in the pattern.
  SupernodalLayout(std::size_t count, const Index* super, const Index* row_start, const Index* row,
                   const LowerColumns& matrix);

 private:
  void place_entries(const LowerColumns& matrix);
  void join_fronts();
  void divide_work();
};

}  // namespace glossa

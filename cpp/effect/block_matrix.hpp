// The global tangent: 3 x 3 blocks between nodes, laid out once, filled many times.
//
// Unknowns are the free displacement components, numbered node by node in a fill-reducing order of the nodes, so that
// the scalar matrix handed to the factorisation needs no further permutation. Only the lower triangle is kept.
// Element contributions are *gathered*: each block sums its sources in a fixed order, whatever the number of threads.
// Nodes tied to a bone have blocks, which eliminate() hands on to the blocks of the bone's pose, but no unknowns.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "bone/bone.hpp"
#include "core/cells.hpp"
#include "core/types.hpp"

namespace glossa {

/// Which displacement components may move: entry 3 n + i, 1 free, 0 held.
using FreeMask = std::vector<std::uint8_t>;

/// Compressed columns of the lower triangle of a symmetric matrix.
struct LowerColumns {
  std::vector<Index> column_start;
  std::vector<Index> row;
  std::vector<double> value;
};

/// A fill-reducing elimination order for the graph whose edges join the nodes of each cell; nodes without free
/// components are left out. Injected by the scene so that this room does not know the factorisation.
using NodeOrdering = std::vector<Index> (*)(const std::vector<Index>& column_start, const std::vector<Index>& row);

class BlockMatrix {
 public:
  /// `elements`: cells whose packed tangents are gathered. `extra`: further groups of nodes that become fully coupled.
  /// `ties`: nodes that follow a bone, if there is one; the free components of its pose are unknowns.
  BlockMatrix(Index node_count, const FreeMask& free, const Cells& elements, const Rows<Index>& extra,
              NodeOrdering ordering, const Ties* ties = nullptr);

  [[nodiscard]] Index unknown_count() const { return static_cast<Index>(component_of_unknown_.size()); }
  /// Flat component (3 n + i) of an unknown.
  [[nodiscard]] const std::vector<Index>& component_of_unknown() const { return component_of_unknown_; }

  /// Sets every block to the sum of its packed element tangents (core/cells.hpp; row-major 3 x 3 blocks) plus
  /// mass_scale times the scalar mass of its node pair.
  void gather(std::span<const double> element_tangents, double mass_scale, int threads);
  /// Adds a symmetric 3 x 3 block that couples nodes a and b as rows a, columns b (and its transpose when a != b).
  void add(Index a, Index b, const Matrix3& block);
  /// Block number and whether it is stored transposed, for repeated adding; -1 where a node is held.
  struct Slot {
    Index block;
    bool transposed;
  };
  [[nodiscard]] Slot slot(Index a, Index b) const;
  void add(Slot slot, const Matrix3& block);
  /// Adds the blocks of the tied nodes to those of the pose, given dx_a / d turn of each tied node; call once, after
  /// all effects have added theirs.
  void eliminate(const std::vector<Matrix3>& turn_gradients);
  /// Adds `shift` to the diagonal of every unknown.
  void shift_diagonal(double shift);

  /// Consistent element masses (packed, one value for each pair) summed into the blocks, once.
  void set_mass(std::span<const double> element_masses);
  /// Adds a point mass (kg); after set_mass.
  void add_mass(Index node, double mass);

  /// The scalar matrix of the current blocks.
  const LowerColumns& columns(int threads);

  [[nodiscard]] std::size_t block_count() const { return block_row_.size(); }

 private:
  struct Source {
    Index offset;  // of the node pair in the packed element array, in blocks
    bool transposed;
  };
  // A block between a tied node and any other, and where it goes. Where both are tied, `other` is the second of them.
  struct TiedBlock {
    Index block;
    Index tied;              // place in the list of ties
    Index other = -1;        // place in the list of ties; -1: the other node is not tied
    Slot centre{-1, false};  // of the pose with the other node
    Slot turn{-1, false};
  };
  void number_nodes(Index node_count, const FreeMask& free, const Cells& elements, const Rows<Index>& extra,
                    NodeOrdering ordering, const Ties* ties);
  void lay_out_blocks(const Cells& elements, const Rows<Index>& extra, const Ties* ties);
  void lay_out_columns();
  void collect_sources(const Cells& elements);
  void collect_ties(const Ties& ties);
  [[nodiscard]] Slot slot_of_ranks(Index i, Index j) const;
  [[nodiscard]] Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(Index b) const {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(blocks_.data() +
                                                                          9 * static_cast<std::size_t>(b));
  }

  std::vector<Index> rank_of_node_;  // -1: held; tied nodes come after those with unknowns
  std::vector<Index> node_of_rank_;
  std::size_t unknown_ranks_ = 0;
  std::vector<std::array<Index, 3>> free_components_;  // per rank: local components, -1 padded
  std::vector<Index> free_count_;                      // per rank
  std::vector<Index> first_unknown_;                   // per rank
  std::vector<Index> component_of_unknown_;
  std::vector<Index> block_start_;   // per rank (block column)
  std::vector<Index> unknown_end_;   // per rank with unknowns: end of its blocks with such rows
  std::vector<Index> block_row_;     // rank of the row, ascending in each column
  std::vector<Index> row_offset_;    // scalar rows above the block in its column, diagonal block included
  std::vector<double> blocks_;       // 9 per block, row-major
  std::vector<double> mass_;         // per block
  std::vector<Index> source_start_;  // per block
  std::vector<Source> sources_;
  std::vector<TiedBlock> tied_blocks_;
  Slot pose_centre_{-1, false}, pose_turn_{-1, false}, pose_cross_{-1, false};  // cross: row turn, column centre
  LowerColumns columns_;
};

}  // namespace glossa

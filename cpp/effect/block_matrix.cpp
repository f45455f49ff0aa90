#include "effect/block_matrix.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace glossa {
namespace {

// Visits the nodes of every cell; a cell with a tied node also couples the pose of the bone.
template <class Visit>
void for_cells(const Cells& elements, const Rows<Index>& extra, const Ties* ties, Visit&& visit) {
  std::vector<Index> cell;
  const auto pass_on = [&](const Index* first, const Index* last) {
    cell.assign(first, last);
    if (ties != nullptr && std::any_of(first, last, [&](Index n) {
          return std::binary_search(ties->nodes.begin(), ties->nodes.end(), n);
        }))
      cell.insert(cell.end(), {ties->centre, ties->turn});
    visit(cell);
  };
  for (std::size_t e = 0; e < elements.count(); ++e) pass_on(elements.begin(e), elements.end(e));
  for (Index r = 0; r < extra.size(); ++r) pass_on(extra.begin(r), extra.end(r));
  if (ties != nullptr)
    for (const Index node : ties->nodes) pass_on(&node, &node + 1);
}

// Lower triangle (row > column, diagonal included) of the graph of the cells, in the numbering of `rank`.
void lower_graph(const std::vector<Index>& rank, Index count, const Cells& elements, const Rows<Index>& extra,
                 const Ties* ties, std::vector<Index>& start, std::vector<Index>& row) {
  std::vector<std::vector<Index>> columns(static_cast<std::size_t>(count));
  for_cells(elements, extra, ties, [&](const std::vector<Index>& nodes) {
    for (const Index a : nodes)
      for (const Index b : nodes) {
        const Index i = rank[static_cast<std::size_t>(a)], j = rank[static_cast<std::size_t>(b)];
        if (i >= 0 && j >= 0 && i >= j) columns[static_cast<std::size_t>(j)].push_back(i);
      }
  });
  start.assign(1, 0);
  row.clear();
  for (auto& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    row.insert(row.end(), column.begin(), column.end());
    start.push_back(static_cast<Index>(row.size()));
  }
}

}  // namespace

BlockMatrix::BlockMatrix(Index node_count, const FreeMask& free, const Cells& elements, const Rows<Index>& extra,
                         NodeOrdering ordering, const Ties* ties) {
  number_nodes(node_count, free, elements, extra, ordering, ties);
  lay_out_blocks(elements, extra, ties);
  lay_out_columns();
  collect_sources(elements);
  if (ties != nullptr) collect_ties(*ties);
  mass_.assign(block_row_.size(), 0.0);
}

void BlockMatrix::number_nodes(Index node_count, const FreeMask& free, const Cells& elements, const Rows<Index>& extra,
                               NodeOrdering ordering, const Ties* ties) {
  rank_of_node_.assign(static_cast<std::size_t>(node_count), -1);
  std::vector<bool> used(static_cast<std::size_t>(node_count), false);
  for (const Index node : elements.nodes) used[static_cast<std::size_t>(node)] = true;
  if (ties != nullptr) {
    for (const Index node : ties->nodes) used[static_cast<std::size_t>(node)] = false;
    for (const Index node : {ties->centre, ties->turn}) used[static_cast<std::size_t>(node)] = true;
  }
  std::vector<Index> movable;
  for (Index n = 0; n < node_count; ++n) {
    const std::uint8_t* mask = free.data() + 3 * static_cast<std::size_t>(n);
    if (used[static_cast<std::size_t>(n)] && (mask[0] || mask[1] || mask[2])) {
      rank_of_node_[static_cast<std::size_t>(n)] = static_cast<Index>(movable.size());
      movable.push_back(n);
    }
  }
  require(!movable.empty(), "constraints: every node is held, nothing is left to solve for");
  std::vector<Index> start, row;
  lower_graph(rank_of_node_, static_cast<Index>(movable.size()), elements, extra, ties, start, row);
  for (const Index old : ordering(start, row)) {
    const Index node = movable[static_cast<std::size_t>(old)];
    rank_of_node_[static_cast<std::size_t>(node)] = static_cast<Index>(node_of_rank_.size());
    node_of_rank_.push_back(node);
  }
  for (const Index node : node_of_rank_) {
    first_unknown_.push_back(unknown_count());
    std::array<Index, 3> components{-1, -1, -1};
    Index count = 0;
    for (Index i = 0; i < 3; ++i)
      if (free[static_cast<std::size_t>(3 * node + i)]) {
        components[static_cast<std::size_t>(count++)] = i;
        component_of_unknown_.push_back(3 * node + i);
      }
    free_components_.push_back(components);
    free_count_.push_back(count);
  }
  unknown_ranks_ = node_of_rank_.size();
  if (ties != nullptr)
    for (const Index node : ties->nodes) {
      rank_of_node_[static_cast<std::size_t>(node)] = static_cast<Index>(node_of_rank_.size());
      node_of_rank_.push_back(node);
    }
}

void BlockMatrix::lay_out_blocks(const Cells& elements, const Rows<Index>& extra, const Ties* ties) {
  lower_graph(rank_of_node_, static_cast<Index>(node_of_rank_.size()), elements, extra, ties, block_start_, block_row_);
  blocks_.assign(9 * block_row_.size(), 0.0);
  for (std::size_t J = 0; J < unknown_ranks_; ++J) {
    const auto first = block_row_.begin() + block_start_[J], last = block_row_.begin() + block_start_[J + 1];
    unknown_end_.push_back(
        static_cast<Index>(std::lower_bound(first, last, static_cast<Index>(unknown_ranks_)) - block_row_.begin()));
  }
}

void BlockMatrix::lay_out_columns() {
  row_offset_.resize(block_row_.size());
  columns_.column_start.assign(1, 0);
  for (std::size_t J = 0; J < unknown_ranks_; ++J) {
    std::vector<Index> rows;
    for (Index b = block_start_[J]; b < unknown_end_[J]; ++b) {
      const auto I = static_cast<std::size_t>(block_row_[static_cast<std::size_t>(b)]);
      row_offset_[static_cast<std::size_t>(b)] = static_cast<Index>(rows.size());
      for (Index k = 0; k < free_count_[I]; ++k) rows.push_back(first_unknown_[I] + k);
    }
    for (Index k = 0; k < free_count_[J]; ++k) {
      columns_.row.insert(columns_.row.end(), rows.begin() + k, rows.end());
      columns_.column_start.push_back(static_cast<Index>(columns_.row.size()));
    }
  }
  columns_.value.assign(columns_.row.size(), 0.0);
}

void BlockMatrix::collect_sources(const Cells& elements) {
  std::vector<std::pair<Index, Source>> found;
  for (std::size_t e = 0; e < elements.count(); ++e) {
    const Index* nodes = elements.begin(e);
    auto pair = static_cast<Index>(e * elements.pairs());
    for (std::size_t b = 0; b < elements.size; ++b)
      for (std::size_t a = 0; a <= b; ++a, ++pair) {
        const Slot s = slot(nodes[a], nodes[b]);
        if (s.block >= 0) found.push_back({s.block, {pair, s.transposed}});
      }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  source_start_.assign(block_row_.size() + 1, 0);
  for (const auto& [block, source] : found) {
    ++source_start_[static_cast<std::size_t>(block) + 1];
    sources_.push_back(source);
  }
  for (std::size_t b = 1; b < source_start_.size(); ++b) source_start_[b] += source_start_[b - 1];
}

BlockMatrix::Slot BlockMatrix::slot(Index a, Index b) const {
  const Index i = rank_of_node_[static_cast<std::size_t>(a)], j = rank_of_node_[static_cast<std::size_t>(b)];
  if (i < 0 || j < 0) return {-1, false};
  const Slot found = slot_of_ranks(i, j);
  require(found.block >= 0,
          "tangent: nodes " + std::to_string(a) + " and " + std::to_string(b) + " are not coupled in the layout");
  return found;
}

BlockMatrix::Slot BlockMatrix::slot_of_ranks(Index i, Index j) const {
  const auto column = static_cast<std::size_t>(std::min(i, j));
  const auto first = block_row_.begin() + block_start_[column], last = block_row_.begin() + block_start_[column + 1];
  const auto it = std::lower_bound(first, last, std::max(i, j));
  if (it == last || *it != std::max(i, j)) return {-1, false};
  return {static_cast<Index>(it - block_row_.begin()), i < j};
}

void BlockMatrix::collect_ties(const Ties& ties) {
  const Index centre = rank_of_node_[static_cast<std::size_t>(ties.centre)],
              turn = rank_of_node_[static_cast<std::size_t>(ties.turn)];
  const auto slot_of = [&](Index i, Index j) { return i < 0 || j < 0 ? Slot{-1, false} : slot_of_ranks(i, j); };
  pose_centre_ = slot_of(centre, centre);
  pose_turn_ = slot_of(turn, turn);
  pose_cross_ = slot_of(turn, centre);
  const auto first_tied = static_cast<Index>(unknown_ranks_);
  for (std::size_t J = 0; J < node_of_rank_.size(); ++J)
    for (Index b = J < unknown_ranks_ ? unknown_end_[J] : block_start_[J]; b < block_start_[J + 1]; ++b) {
      const auto column = static_cast<Index>(J);
      if (column == centre || column == turn) continue;  // such a block stays empty
      TiedBlock tied{b, block_row_[static_cast<std::size_t>(b)] - first_tied};
      if (column >= first_tied)
        tied.other = column - first_tied;
      else {
        tied.centre = slot_of(centre, column);
        tied.turn = slot_of(turn, column);
      }
      tied_blocks_.push_back(tied);
    }
}

void BlockMatrix::eliminate(const std::vector<Matrix3>& turn_gradients) {
  for (const TiedBlock& tied : tied_blocks_) {
    const Matrix3 B = block(tied.block);
    const Matrix3& T = turn_gradients[static_cast<std::size_t>(tied.tied)];
    if (tied.other < 0) {
      add(tied.centre, B);
      add(tied.turn, T.transpose() * B);
    } else if (tied.other == tied.tied) {
      add(pose_centre_, B);
      add(pose_turn_, T.transpose() * B * T);
      add(pose_cross_, T.transpose() * B);
    } else {
      const Matrix3& S = turn_gradients[static_cast<std::size_t>(tied.other)];
      const Matrix3 turned = T.transpose() * B * S;
      add(pose_centre_, B + B.transpose());
      add(pose_turn_, turned + turned.transpose());
      add(pose_cross_, T.transpose() * B + S.transpose() * B.transpose());
    }
  }
}

void BlockMatrix::set_mass(std::span<const double> element_masses) {
  for (std::size_t b = 0; b < mass_.size(); ++b) {
    mass_[b] = 0.0;
    for (Index s = source_start_[b]; s < source_start_[b + 1]; ++s)
      mass_[b] += element_masses[static_cast<std::size_t>(sources_[static_cast<std::size_t>(s)].offset)];
  }
}

void BlockMatrix::add_mass(Index node, double mass) {
  const Slot s = slot(node, node);
  if (s.block >= 0) mass_[static_cast<std::size_t>(s.block)] += mass;
}

void BlockMatrix::gather(std::span<const double> element_tangents, double mass_scale, int threads) {
  parallel_ranges(static_cast<int>(block_row_.size()), threads, [&](int begin, int end) {
    for (int b = begin; b < end; ++b) {
      double sum[9] = {};
      for (Index s = source_start_[static_cast<std::size_t>(b)]; s < source_start_[static_cast<std::size_t>(b) + 1];
           ++s) {
        const Source source = sources_[static_cast<std::size_t>(s)];
        const double* from = element_tangents.data() + 9 * static_cast<std::size_t>(source.offset);
        if (source.transposed)
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) sum[3 * i + j] += from[3 * j + i];
        else
          for (int k = 0; k < 9; ++k) sum[k] += from[k];
      }
      const double m = mass_scale * mass_[static_cast<std::size_t>(b)];
      sum[0] += m;
      sum[4] += m;
      sum[8] += m;
      std::copy(sum, sum + 9, blocks_.begin() + 9 * b);
    }
  });
}

void BlockMatrix::add(Slot s, const Matrix3& block) {
  if (s.block < 0) return;
  double* to = blocks_.data() + 9 * static_cast<std::size_t>(s.block);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) to[3 * i + j] += s.transposed ? block(j, i) : block(i, j);
}

void BlockMatrix::add(Index a, Index b, const Matrix3& block) {
  add(slot(a, b), block);
}

void BlockMatrix::shift_diagonal(double shift) {
  for (std::size_t J = 0; J < unknown_ranks_; ++J)
    for (const int k : {0, 4, 8})
      blocks_[9 * static_cast<std::size_t>(block_start_[J]) + static_cast<std::size_t>(k)] += shift;
}

const LowerColumns& BlockMatrix::columns(int threads) {
  parallel_ranges(static_cast<int>(unknown_ranks_), threads, [&](int begin, int end) {
    for (auto J = static_cast<std::size_t>(begin); J < static_cast<std::size_t>(end); ++J) {
      for (Index c = 0; c < free_count_[J]; ++c) {
        const Index j = free_components_[J][static_cast<std::size_t>(c)];
        double* column =
            columns_.value.data() + columns_.column_start[static_cast<std::size_t>(first_unknown_[J] + c)] - c;
        for (Index b = block_start_[J]; b < unknown_end_[J]; ++b) {
          const auto I = static_cast<std::size_t>(block_row_[static_cast<std::size_t>(b)]);
          const double* block = blocks_.data() + 9 * static_cast<std::size_t>(b);
          double* to = column + row_offset_[static_cast<std::size_t>(b)];
          const Index skip = I == J ? c : 0;
          for (Index r = skip; r < free_count_[I]; ++r)
            to[r] = block[3 * free_components_[I][static_cast<std::size_t>(r)] + j];
        }
      }
    }
  });
  return columns_;
}

}  // namespace glossa

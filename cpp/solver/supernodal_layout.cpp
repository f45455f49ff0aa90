#include "solver/supernodal_layout.hpp"

#include <algorithm>

namespace glossa {
namespace {

constexpr Index width = 8;  // floats of a pack
// A branch is split while it holds more than this share of all work: enough branches for a few threads.
constexpr double largest_branch = 0.15;

Index padded(Index n) {
  return (n + width - 1) / width * width;
}

std::size_t size(Index n) {
  return static_cast<std::size_t>(n);
}

double work(const Supernode& s) {
  const double c = s.columns, b = s.below;
  return c * c * c / 3.0 + c * c * b + c * b * b;
}

}  // namespace

SupernodalLayout::SupernodalLayout(std::size_t count, const Index* super, const Index* row_start, const Index* row,
                                   const LowerColumns& matrix) {
  longest = width;
  for (std::size_t k = 0; k < count; ++k) {
    Supernode s{};
    s.first = super[k];
    s.columns = super[k + 1] - super[k];
    s.below = row_start[k + 1] - row_start[k] - s.columns;
    s.padded_columns = padded(s.columns);
    s.padded_below = padded(s.below);
    s.row_start = static_cast<Index>(rows.size());
    rows.insert(rows.end(), row + row_start[k] + s.columns, row + row_start[k + 1]);
    s.diagonal = value_count;
    value_count += size(s.columns) * size(s.padded_columns);
    s.off = value_count;
    value_count += size(s.columns) * size(s.padded_below);
    longest = std::max({longest, s.padded_columns, s.padded_below});
    supernodes.push_back(s);
  }
  place_entries(matrix);
  join_fronts();
  divide_work();
}

void SupernodalLayout::place_entries(const LowerColumns& matrix) {
  entry.resize(matrix.row.size());
  for (const Supernode& s : supernodes)
    for (Index j = 0; j < s.columns; ++j) {
      const Index* const below = rows.data() + s.row_start;
      for (Index k = matrix.column_start[size(s.first + j)]; k < matrix.column_start[size(s.first + j) + 1]; ++k) {
        const Index local = matrix.row[size(k)] - s.first;
        if (local < s.columns) {
          entry[size(k)] = s.diagonal + size(j) * size(s.padded_columns) + size(local);
        } else {
          const Index* at = std::lower_bound(below, below + s.below, matrix.row[size(k)]);
          entry[size(k)] = s.off + size(j) * size(s.padded_below) + static_cast<std::size_t>(at - below);
        }
      }
    }
}

void SupernodalLayout::join_fronts() {
  const std::size_t n = supernodes.empty() ? 0 : size(supernodes.back().first + supernodes.back().columns);
  std::vector<Index> owner(n), parent(supernodes.size(), -1);
  for (std::size_t k = 0; k < supernodes.size(); ++k)
    for (Index j = 0; j < supernodes[k].columns; ++j) owner[size(supernodes[k].first + j)] = static_cast<Index>(k);
  place_in_next.resize(rows.size());
  passed_columns.assign(supernodes.size(), 0);
  for (std::size_t k = 0; k < supernodes.size(); ++k) {
    const Supernode& s = supernodes[k];
    if (s.below == 0) continue;
    parent[k] = owner[size(rows[size(s.row_start)])];
    const Supernode& next = supernodes[size(parent[k])];
    const Index* to = rows.data() + next.row_start;
    for (Index i = 0; i < s.below; ++i) {
      const Index r = rows[size(s.row_start + i)];
      Index& place = place_in_next[size(s.row_start + i)];
      if (r < next.first + next.columns) {
        place = r - next.first;
        ++passed_columns[k];
      } else {
        while (*to != r) ++to;
        place = next.columns + static_cast<Index>(to - (rows.data() + next.row_start));
      }
    }
  }
  std::vector<std::vector<Index>> of(supernodes.size());
  for (std::size_t k = 0; k < supernodes.size(); ++k)
    if (parent[k] >= 0) of[size(parent[k])].push_back(static_cast<Index>(k));
  for (const auto& list : of) {
    children.values.insert(children.values.end(), list.begin(), list.end());
    children.push_row();
  }
}

void SupernodalLayout::divide_work() {
  std::vector<double> below(supernodes.size());  // work of the subtree
  std::vector<char> is_child(supernodes.size(), 0);
  double whole = 0.0;
  for (std::size_t k = 0; k < supernodes.size(); ++k) {
    below[k] = work(supernodes[k]);
    whole += below[k];
    const auto row = static_cast<Index>(k);
    for (const Index* c = children.begin(row); c != children.end(row); ++c) {
      below[k] += below[size(*c)];
      is_child[size(*c)] = 1;
    }
  }
  std::vector<Index> open;
  for (std::size_t k = 0; k < supernodes.size(); ++k)
    if (is_child[k] == 0) open.push_back(static_cast<Index>(k));
  while (!open.empty()) {
    const Index k = open.back();
    open.pop_back();
    if (below[size(k)] > largest_branch * whole) {
      trunk.push_back(k);
      open.insert(open.end(), children.begin(k), children.end(k));
      continue;
    }
    std::vector<Index> branch{k};
    for (std::size_t i = 0; i < branch.size(); ++i)
      branch.insert(branch.end(), children.begin(branch[i]), children.end(branch[i]));
    std::sort(branch.begin(), branch.end());
    branches.push_back(std::move(branch));
  }
  std::sort(trunk.begin(), trunk.end());
  // The heaviest first, so that threads end together.
  std::stable_sort(branches.begin(), branches.end(),
                   [&](const auto& a, const auto& b) { return below[size(a.back())] > below[size(b.back())]; });
}

}  // namespace glossa

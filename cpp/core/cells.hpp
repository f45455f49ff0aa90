// Cells of a mesh that have equally many nodes: what is assembled, whatever the element.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// Cell c is nodes[size c] ... nodes[size c + size - 1]. Packed matrices of a cell hold its node pairs (a <= b) column
/// by column: (0, 0), (0, 1), (1, 1), (0, 2), ...
struct Cells {
  std::size_t size = 0;  ///< nodes of each cell
  std::vector<Index> nodes;

  Cells() = default;
  Cells(const std::vector<Hexahedron>& hexahedra) : size(8) {  // NOLINT(google-explicit-constructor)
    nodes.reserve(8 * hexahedra.size());
    for (const Hexahedron& corners : hexahedra) nodes.insert(nodes.end(), corners.begin(), corners.end());
  }

  [[nodiscard]] std::size_t count() const { return size == 0 ? 0 : nodes.size() / size; }
  [[nodiscard]] const Index* begin(std::size_t cell) const { return nodes.data() + size * cell; }
  [[nodiscard]] const Index* end(std::size_t cell) const { return begin(cell) + size; }
  [[nodiscard]] std::size_t pairs() const { return size * (size + 1) / 2; }
};

}  // namespace glossa

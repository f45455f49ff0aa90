// Eight by eight, the hexahedra of a mesh of even division are the octants of hexahedra of 27 nodes.
#pragma once

#include <array>

#include "core/cells.hpp"
#include "mesh/hex_mesh.hpp"

namespace glossa {

/// Hexahedra of 27 nodes (numbered as in mesh/quadratic_hex.hpp) that fill the body of the mesh they were made from.
struct QuadraticCells {
  Cells cells;
  std::vector<std::array<Index, 8>> octants;  ///< of each cell: the hexahedra of the mesh that it consists of
};

/// Finds the 2 x 2 x 2 groups by the mesh's connections alone: the node in the middle of a group has eight hexahedra
/// around it, and the middle of a neighbouring group lies two edges further, through the middle of their common face;
/// so one group fixes all others of a connected body, and the first is found by trying the corners of a hexahedron.
/// InputError, naming a hexahedron, if the mesh cannot be grouped, or if a cell is not positive at a Gauss point.
[[nodiscard]] QuadraticCells quadratic_cells(const HexMesh& mesh);

}  // namespace glossa

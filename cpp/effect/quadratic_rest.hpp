// What the elements of 27 nodes know of the body at rest.
#pragma once

#include <vector>

#include "effect/quadratic_kernel.hpp"
#include "mesh/quadratic_cells.hpp"

namespace glossa {

/// Reference gradients, weights and projections of all cells, in batches of four.
[[nodiscard]] std::vector<QuadraticBatch> quadratic_batches(const HexMesh& mesh, const QuadraticCells& cells);

/// Packed consistent masses (378 node pairs a <= b per cell, kg) for a density in kg/m3.
[[nodiscard]] std::vector<double> quadratic_masses(const HexMesh& mesh, const Cells& cells, double density);

}  // namespace glossa

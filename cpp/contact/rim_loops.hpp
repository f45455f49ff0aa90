// The rims of a wall as closed lines: its outer edge and its holes.
#pragma once

#include "contact/wall_topology.hpp"

namespace glossa {

struct RimLoop {
  std::vector<Index> edges;     // of the topology, in order along the loop
  std::vector<Index> vertices;  // of the topology, in order; edge k starts at vertex k
  double length = 0.0;          // m
  Index sheet = 0;              // connected piece of the wall it bounds
  bool outer = false;           // the longest loop of its sheet; the others are holes
};

struct Rims {
  std::vector<RimLoop> loops;
  std::vector<Index> loop_of_edge;    // -1 where the edge is no rim
  std::vector<Index> loop_of_vertex;  // -1 where no rim passes; the first where several do
};

/// Loops of edges with one face. At a vertex a loop goes on to the rim reached by turning around the vertex from face
/// to face, whichever way round these run; holes that meet in a vertex are one, and one that meets the outer rim in a
/// vertex belongs to it.
[[nodiscard]] Rims rim_loops(const WallTopology& wall);

}  // namespace glossa

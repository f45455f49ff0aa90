// Element tangents and masses without meaning, as BlockMatrix gathers them.
#pragma once

#include <vector>

#include "../fixture.hpp"

namespace glossa::test {

/// Appends symmetric tangents and masses of all elements and tells put(a, b, block, mass) of every pair of nodes.
template <class Put>
void random_tangents(const HexMesh& mesh, Random& random, std::vector<double>& tangents, std::vector<double>& masses,
                     Put&& put) {
  for (const Hexahedron& element : mesh.hexahedra())
    for (std::size_t b = 0; b < 8; ++b)
      for (std::size_t a = 0; a <= b; ++a) {
        Matrix3 block = random.matrix(1.0);
        if (a == b) block = (block + block.transpose()).eval();
        for (Eigen::Index i = 0; i < 3; ++i)
          for (Eigen::Index j = 0; j < 3; ++j) tangents.push_back(block(i, j));
        masses.push_back(random(0.0, 1.0));
        put(element[a], element[b], block, masses.back());
      }
}

}  // namespace glossa::test

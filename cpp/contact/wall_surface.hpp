// A rigid wall as it is given.
#pragma once

#include <array>
#include <vector>

#include "core/types.hpp"

namespace glossa {

using Triangle = std::array<Index, 3>;

/// Triangles between vertices (m), open or closed, normals (counter-clockwise corners) towards the tongue.
struct WallSurface {
  std::vector<Vector3> vertices;
  std::vector<Triangle> triangles;
};

}  // namespace glossa

// The trilinear hexahedron: corner order, shape functions, 2 x 2 x 2 Gauss rule.
#pragma once

#include <array>
#include <cmath>

#include "core/types.hpp"

namespace glossa::hex {

inline constexpr int corners = 8;
inline constexpr int points = 8;

/// Natural coordinates of the corners, VTK order.
inline constexpr std::array<std::array<double, 3>, corners> corner{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};

/// Faces as corner lists, normals outward.
inline constexpr std::array<std::array<int, 4>, 6> faces{
    {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};

using CornerValues = std::array<double, corners>;
using CornerGradients = Eigen::Matrix<double, 3, corners>;

inline CornerValues shape(const std::array<double, 3>& xi) {
  CornerValues n;
  for (std::size_t a = 0; a < corners; ++a)
    n[a] = 0.125 * (1 + corner[a][0] * xi[0]) * (1 + corner[a][1] * xi[1]) * (1 + corner[a][2] * xi[2]);
  return n;
}

/// d(shape)/d(xi), one column per corner.
inline CornerGradients shape_gradient(const std::array<double, 3>& xi) {
  CornerGradients g;
  for (std::size_t a = 0; a < corners; ++a) {
    const double s0 = 1 + corner[a][0] * xi[0];
    const double s1 = 1 + corner[a][1] * xi[1];
    const double s2 = 1 + corner[a][2] * xi[2];
    g.col(static_cast<Eigen::Index>(a)) << 0.125 * corner[a][0] * s1 * s2, 0.125 * corner[a][1] * s0 * s2,
        0.125 * corner[a][2] * s0 * s1;
  }
  return g;
}

/// Natural coordinates of Gauss point q; every weight is 1.
inline std::array<double, 3> gauss_point(std::size_t q) {
  const double r = 1.0 / std::sqrt(3.0);
  return {corner[q][0] * r, corner[q][1] * r, corner[q][2] * r};
}

}  // namespace glossa::hex

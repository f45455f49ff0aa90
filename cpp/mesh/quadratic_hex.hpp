// The triquadratic hexahedron of 27 nodes: node order, shape functions, 3 x 3 x 3 Gauss rule, octants.
//
// Nodes, Gauss points and octants are numbered as tensor products, the first natural coordinate fastest: node
// i + 3 j + 9 k lies at (i - 1, j - 1, k - 1), octant i + 2 j + 4 k is centred at (i, j, k) - 1/2.
#pragma once

#include <array>

#include "core/types.hpp"

namespace glossa::hex27 {

inline constexpr std::size_t nodes = 27;
inline constexpr std::size_t points = 27;
inline constexpr std::size_t octants = 8;

using NodeValues = std::array<double, nodes>;
using NodeGradients = Eigen::Matrix<double, 3, 27>;

/// Natural coordinates and weight of Gauss point q.
struct GaussPoint {
  std::array<double, 3> xi;
  double weight;
};
inline GaussPoint gauss_point(std::size_t q) {
  constexpr std::array<double, 3> place{-0.7745966692414834, 0.0, 0.7745966692414834},
      weight{5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  const std::size_t i = q % 3, j = q / 3 % 3, k = q / 9;
  return {{place[i], place[j], place[k]}, weight[i] * weight[j] * weight[k]};
}

/// Values and slopes of the three quadratic polynomials that are one at -1, 0, 1 and zero at the others.
struct Line {
  std::array<double, 3> value, slope;
};
inline Line line(double x) {
  return {{0.5 * x * (x - 1), 1 - x * x, 0.5 * x * (x + 1)}, {x - 0.5, -2 * x, x + 0.5}};
}

inline NodeValues shape(const std::array<double, 3>& xi) {
  const std::array<Line, 3> l{line(xi[0]), line(xi[1]), line(xi[2])};
  NodeValues n;
  for (std::size_t a = 0; a < nodes; ++a) n[a] = l[0].value[a % 3] * l[1].value[a / 3 % 3] * l[2].value[a / 9];
  return n;
}

/// d(shape)/d(xi), one column per node.
inline NodeGradients shape_gradient(const std::array<double, 3>& xi) {
  const std::array<Line, 3> l{line(xi[0]), line(xi[1]), line(xi[2])};
  NodeGradients g;
  for (std::size_t a = 0; a < nodes; ++a) {
    const std::size_t i = a % 3, j = a / 3 % 3, k = a / 9;
    g.col(static_cast<Eigen::Index>(a)) << l[0].slope[i] * l[1].value[j] * l[2].value[k],
        l[0].value[i] * l[1].slope[j] * l[2].value[k], l[0].value[i] * l[1].value[j] * l[2].slope[k];
  }
  return g;
}

}  // namespace glossa::hex27

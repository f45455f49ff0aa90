// Deformation and tangent at one Gauss point of four elements of any number of nodes: what the tangents of all elements
// have in common. Only for kernels, which are compiled once for each instruction set with GLOSSA_KERNEL naming it.
#pragma once

#include "core/pack.hpp"

#ifndef GLOSSA_KERNEL
#error "GLOSSA_KERNEL must name the instruction set"
#endif

namespace glossa::GLOSSA_KERNEL {
namespace {

/// Deformation at one Gauss point of four elements.
struct PointState {
  Pack F[3][3];
  Pack H[3][3];  ///< F^(-T)
  Pack J;
  Pack trace;
};

/// F, H, J and tr F'F of current positions x, given the reference gradients of the nodes (1/m).
template <int nodes>
inline void deform(const double (&gradient)[nodes][3][lanes], const Pack (&x)[nodes][3], PointState& s) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Pack sum = x[0][i] * load(gradient[0][j]);
      for (int a = 1; a < nodes; ++a) sum += x[a][i] * load(gradient[a][j]);
      s.F[i][j] = sum;
    }
  const auto& F = s.F;
  Pack cofactor[3][3];
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = F[i1][j1] * F[i2][j2] - F[i1][j2] * F[i2][j1];
    }
  }
  s.J = F[0][0] * cofactor[0][0] + F[0][1] * cofactor[0][1] + F[0][2] * cofactor[0][2];
  const Pack inverse = 1.0 / s.J;
  s.trace = splat(0.0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      s.H[i][j] = cofactor[i][j] * inverse;
      s.trace += F[i][j] * F[i][j];
    }
}

/// Coefficients of the tangent at one Gauss point, weight and stage scale included.
struct Coefficients {
  Pack ff, fg, gg, swap, identity;
  Pack spatial;  ///< of (g_a . g_b) 1: viscosity only
};

/// Adds one Gauss point to the packed tangent K of its element, f_a = F G_a, g_a = H G_a.
template <bool viscous, int nodes>
inline void add_tangent(const double (&gradient)[nodes][3][lanes], const Pack (&f)[nodes][3], const Pack (&g)[nodes][3],
                        const Coefficients& c, Pack (&K)[nodes * (nodes + 1) / 2][9]) {
  int pair = 0;
  for (int b = 0; b < nodes; ++b) {
    Pack h[3], k[3], swapped[3], G[3];
    for (int j = 0; j < 3; ++j) {
      h[j] = c.ff * f[b][j] + c.fg * g[b][j];
      k[j] = c.fg * f[b][j] + c.gg * g[b][j];
      swapped[j] = c.swap * g[b][j];
      G[j] = c.identity * load(gradient[b][j]);
    }
    for (int a = 0; a <= b; ++a, ++pair) {
      Pack* block = K[pair];
      Pack diagonal = load(gradient[a][0]) * G[0] + load(gradient[a][1]) * G[1] + load(gradient[a][2]) * G[2];
      if constexpr (viscous) diagonal += c.spatial * (g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2]);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) block[3 * i + j] += f[a][i] * h[j] + g[a][i] * k[j] + swapped[i] * g[a][j];
      block[0] += diagonal;
      block[4] += diagonal;
      block[8] += diagonal;
    }
  }
}

}  // namespace
}  // namespace glossa::GLOSSA_KERNEL

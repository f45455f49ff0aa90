// Forces of four hexahedra at a time. Compiled once for each instruction set, with GLOSSA_KERNEL naming it; uses no
// library templates, so that no code of the wider instruction set can reach the rest of the program.
//
// All is done in natural coordinates xi. With N = dx/dxi (3 x 3) at a Gauss point, M = (dX/dxi)^(-1) (dX/dxi)^(-T) the
// contravariant metric at rest and w its weight:
//   F F^T = N M N^T,   t = N : N M,   w J = det N,   w J F^(-T) G_a = cof(N) dN_a/dxi,   F G_a = (N M) dN_a/dxi,
// so that the force on corner a is P dN_a/dxi with one 3 x 3 matrix P for each Gauss point. dx/dxi_k and the sum over
// the Gauss points go through the four edges along xi_k: the trilinear derivative does not vary along its own edge.
#include "core/pack.hpp"
#include "effect/elasticity_kernel.hpp"

#ifndef GLOSSA_KERNEL
#error "GLOSSA_KERNEL must name the instruction set"
#endif

namespace glossa::GLOSSA_KERNEL {
namespace {

// For each natural direction, the corners at both ends of its four edges: low and high in the first of the other two
// directions, then in the second.
constexpr int edge_start[3][4] = {{0, 3, 4, 7}, {0, 1, 4, 5}, {0, 1, 3, 2}};
constexpr int edge_end[3][4] = {{1, 2, 5, 6}, {3, 2, 7, 6}, {4, 5, 7, 6}};
// The edge of each direction on whose side a Gauss point (numbered as the corners) lies.
constexpr int edge_of[3][8] = {{0, 0, 1, 1, 2, 2, 3, 3}, {0, 1, 1, 0, 2, 3, 3, 2}, {0, 1, 3, 2, 0, 1, 3, 2}};

// Linear interpolation between two edges at the near and the far Gauss abscissa, (1 +- 3^(-1/2)) / 2; halves of them
// for the second direction, as dN/dxi of an edge is 1/2.
constexpr double near_share = 0.78867513459481288, far_share = 0.21132486540518712;
constexpr double near_half = 0.5 * near_share, far_half = 0.5 * far_share;

/// A field's derivatives in natural coordinates: [component][direction][edge].
struct NaturalGradient {
  Pack along[3][3][4];
};

GLOSSA_ALWAYS_INLINE void differentiate(const Pack x[8][3], NaturalGradient& gradient) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      Pack edge[4];
      for (int m = 0; m < 4; ++m) edge[m] = x[edge_end[k][m]][i] - x[edge_start[k][m]][i];
      const Pack low0 = near_share * edge[0] + far_share * edge[1], low1 = far_share * edge[0] + near_share * edge[1];
      const Pack high0 = near_share * edge[2] + far_share * edge[3], high1 = far_share * edge[2] + near_share * edge[3];
      gradient.along[i][k][0] = near_half * low0 + far_half * high0;
      gradient.along[i][k][1] = near_half * low1 + far_half * high1;
      gradient.along[i][k][2] = far_half * low0 + near_half * high0;
      gradient.along[i][k][3] = far_half * low1 + near_half * high1;
    }
}

/// The transpose of differentiate.
GLOSSA_ALWAYS_INLINE void collect(const NaturalGradient& stress, Pack force[8][4]) {
  for (int n = 0; n < 8; ++n)
    for (int i = 0; i < 4; ++i) force[n][i] = splat(0.0);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Pack* s = stress.along[i][k];
      const Pack low0 = near_half * s[0] + far_half * s[2], low1 = near_half * s[1] + far_half * s[3];
      const Pack high0 = far_half * s[0] + near_half * s[2], high1 = far_half * s[1] + near_half * s[3];
      const Pack edge[4] = {near_share * low0 + far_share * low1, far_share * low0 + near_share * low1,
                            near_share * high0 + far_share * high1, far_share * high0 + near_share * high1};
      for (int m = 0; m < 4; ++m) {
        force[edge_end[k][m]][i] += edge[m];
        force[edge_start[k][m]][i] -= edge[m];
      }
    }
}

GLOSSA_ALWAYS_INLINE void at_point(const NaturalGradient& gradient, int q, Pack N[3][3]) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) N[i][k] = gradient.along[i][k][edge_of[k][q]];
}

GLOSSA_ALWAYS_INLINE void cofactors(const Pack N[3][3], Pack cofactor[3][3]) {
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = N[i1][j1] * N[i2][j2] - N[i1][j2] * N[i2][j1];
    }
  }
}

// What the Gauss points of four elements have in common with the first pass over them.
struct Points {
  Pack NM[8][3][3];
  Pack determinant[8];  // w J
  Pack trace[8];
};

GLOSSA_ALWAYS_INLINE void measure(const RestBatch& rest, const NaturalGradient& gradient, Points& points) {
  for (int q = 0; q < 8; ++q) {
    Pack N[3][3];
    at_point(gradient, q, N);
    const Pack m00 = load(rest.metric[q][0]), m11 = load(rest.metric[q][1]), m22 = load(rest.metric[q][2]);
    const Pack m01 = load(rest.metric[q][3]), m02 = load(rest.metric[q][4]), m12 = load(rest.metric[q][5]);
    Pack trace = splat(0.0);
    for (int i = 0; i < 3; ++i) {
      points.NM[q][i][0] = N[i][0] * m00 + N[i][1] * m01 + N[i][2] * m02;
      points.NM[q][i][1] = N[i][0] * m01 + N[i][1] * m11 + N[i][2] * m12;
      points.NM[q][i][2] = N[i][0] * m02 + N[i][1] * m12 + N[i][2] * m22;
      for (int k = 0; k < 3; ++k) trace += N[i][k] * points.NM[q][i][k];
    }
    points.trace[q] = trace;
    points.determinant[q] = N[0][0] * (N[1][1] * N[2][2] - N[1][2] * N[2][1]) +
                            N[0][1] * (N[1][2] * N[2][0] - N[1][0] * N[2][2]) +
                            N[0][2] * (N[1][0] * N[2][1] - N[1][1] * N[2][0]);
  }
}

template <bool mean_dilatation, bool viscous>
void sweep_batch(const ElasticSweep& sweep, int batch) {
  const RestBatch& rest = sweep.batches[batch];
  const std::size_t first = static_cast<std::size_t>(batch) * lanes;
  const double c10 = sweep.law.c10, c20 = sweep.law.c20, kappa = sweep.law.kappa;
  NaturalGradient gradient, velocity_gradient, sum;
  {
    Pack x[8][3];
    gather(sweep.positions, rest.corner, x);
    differentiate(x, gradient);
    if constexpr (viscous) {
      gather(sweep.velocities, rest.corner, x);
      differentiate(x, velocity_gradient);
    }
  }
  Points points;
  measure(rest, gradient, points);

  Pack volume = splat(0.0), least = splat(1e300);
  Pack J[8], cube[8];
  for (int q = 0; q < 8; ++q) {
    J[q] = points.determinant[q] / load(rest.weight[q]);
    volume += points.determinant[q];
    least = smaller(least, J[q]);
  }
  for (int q = 0; q < 8; ++q) cube[q] = inverse_cube_root(J[q]);
  const Pack V = load(rest.volume), scale = load(sweep.isochoric_scale + first);
  const Pack theta = volume / V;
  Pack pressure = splat(0.0), isochoric = splat(0.0), volumetric = splat(0.0);
  if constexpr (mean_dilatation) {
    pressure = sweep.volumetric_scale * kappa * (theta - 1.0) + load(sweep.pressure_offset + first);
    volumetric = V * (0.5 * kappa) * (theta - 1.0) * (theta - 1.0);
  }

  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      for (int m = 0; m < 4; ++m) sum.along[i][k][m] = splat(0.0);
  for (int q = 0; q < 8; ++q) {
    const Pack w = load(rest.weight[q]), a = cube[q] * cube[q];
    const Pack i1 = a * points.trace[q] - 3.0;
    const Pack slope = c10 + (2.0 * c20) * i1;
    const Pack third = points.trace[q] * (1.0 / 3.0);
    isochoric += w * (c10 + c20 * i1) * i1;
    if constexpr (!mean_dilatation) {
      pressure = sweep.volumetric_scale * kappa * (J[q] - 1.0);
      volumetric += w * (0.5 * kappa) * (J[q] - 1.0) * (J[q] - 1.0);
    }
    const Pack stress = scale * w * slope * 2.0 * a;
    const Pack inverse = 1.0 / points.determinant[q];
    Pack N[3][3], cofactor[3][3], P[3][3];
    at_point(gradient, q, N);
    cofactors(N, cofactor);
    const auto& NM = points.NM[q];
    Pack along_F = stress;
    if constexpr (viscous) {
      // `shear` is the coefficient of dev(D), `rank` that of (dI/dt) dI_a / (2 a)^2.
      const Pack shear = (2.0 * sweep.viscosity) * stress * third;
      const Pack rank = sweep.viscosity * scale * w * (8.0 * c20) * a * a;
      const Pack bulk = mean_dilatation ? splat(0.0) : sweep.viscosity * kappa * points.determinant[q] * J[q];
      Pack rate[3][3], L[3][3], along = splat(0.0);
      at_point(velocity_gradient, q, rate);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          L[i][j] = inverse * (rate[i][0] * cofactor[j][0] + rate[i][1] * cofactor[j][1] + rate[i][2] * cofactor[j][2]);
          along += rate[i][j] * NM[i][j];
        }
      const Pack dilation = L[0][0] + L[1][1] + L[2][2];
      const Pack stretching = rank * (along - third * dilation);
      along_F += stretching;
      Pack S[3][3];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) S[i][j] = 0.5 * shear * inverse * (L[i][j] + L[j][i]);
      const Pack mean = inverse * (bulk * dilation - (1.0 / 3.0) * shear * dilation - third * along_F) + pressure;
      for (int i = 0; i < 3; ++i) S[i][i] += mean;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          P[i][k] = along_F * NM[i][k] + S[i][0] * cofactor[0][k] + S[i][1] * cofactor[1][k] + S[i][2] * cofactor[2][k];
    } else {
      const Pack mean = pressure - inverse * third * stress;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) P[i][k] = along_F * NM[i][k] + mean * cofactor[i][k];
    }
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) sum.along[i][k][edge_of[k][q]] += P[i][k];
  }

  Pack force[8][4];
  collect(sum, force);
  store(sweep.dilatation + first, theta);
  store(sweep.isochoric_energy + first, isochoric);
  store(sweep.volumetric_energy + first, volumetric);
  store(sweep.least_jacobian + first, least);
  double* to = sweep.force + first * element_force_size;
  for (int n = 0; n < 8; ++n) {
    transpose(force[n][0], force[n][1], force[n][2], force[n][3]);
    for (std::size_t lane = 0; lane < lanes; ++lane)
      store(to + lane * element_force_size + 4 * static_cast<std::size_t>(n), force[n][lane]);
  }
}

}  // namespace

void sweep_forces(const ElasticSweep& sweep, int begin, int end) {
  using Batch = void (*)(const ElasticSweep&, int);
  static constexpr Batch kinds[2][2] = {{sweep_batch<false, false>, sweep_batch<false, true>},
                                        {sweep_batch<true, false>, sweep_batch<true, true>}};
  const Batch kind = kinds[sweep.mean_dilatation ? 1 : 0][sweep.velocities ? 1 : 0];
  for (int batch = begin; batch < end; ++batch) kind(sweep, batch);
}

}  // namespace glossa::GLOSSA_KERNEL

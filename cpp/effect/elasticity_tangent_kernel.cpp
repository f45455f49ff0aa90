// Tangents of four hexahedra at a time. Compiled once for each instruction set, with GLOSSA_KERNEL naming it; uses no
// library templates, so that no code of the wider instruction set can reach the rest of the program.
#include "effect/elasticity_kernel.hpp"

#include "core/pack.hpp"
#include "effect/tangent_point.hpp"

#ifndef GLOSSA_KERNEL
#error "GLOSSA_KERNEL must name the instruction set"
#endif

namespace glossa::GLOSSA_KERNEL {
namespace {

struct Totals {
  Pack volume_gradient[8][3];
  Pack K[36][9];
};

template <bool mean_dilatation, bool viscous>
inline void integrate(const ElasticSweep& sweep, const RestBatch& rest, const Pack (&x)[8][3], Pack scale,
                      Pack pressure, Pack offset, Totals& t) {
  const double c10 = sweep.law.c10, c20 = sweep.law.c20, kappa = sweep.law.kappa, vscale = sweep.volumetric_scale;
  const double share = viscous ? sweep.viscous_share : 0.0;
  for (int q = 0; q < 8; ++q) {
    PointState s;
    deform(rest.gradient[q], x, s);
    const Pack w = load(rest.weight[q]);
    const Pack cube = inverse_cube_root(s.J);
    const Pack a = cube * cube;
    const Pack i1 = a * s.trace - 3.0;
    const Pack slope = c10 + (2.0 * c20) * i1;
    const Pack third = s.trace * (1.0 / 3.0);
    const Pack stress = scale * w * slope * 2.0 * a;
    const Pack wJ = w * s.J;
    Pack point_pressure = pressure;
    if constexpr (!mean_dilatation) point_pressure = kappa * (s.J - 1.0);

    Pack f[8][3], g[8][3];
    for (int n = 0; n < 8; ++n) {
      const Pack G0 = load(rest.gradient[q][n][0]), G1 = load(rest.gradient[q][n][1]),
                 G2 = load(rest.gradient[q][n][2]);
      for (int i = 0; i < 3; ++i) {
        f[n][i] = s.F[i][0] * G0 + s.F[i][1] * G1 + s.F[i][2] * G2;
        g[n][i] = s.H[i][0] * G0 + s.H[i][1] * G1 + s.H[i][2] * G2;
        t.volume_gradient[n][i] += wJ * g[n][i];
      }
    }
    Pack rank = scale * w * (8.0 * c20) * a * a;  // W'' dI dI', dI_a = 2 a (f_a - t/3 g_a)
    if constexpr (viscous) rank *= 1.0 + share;
    const Pack geometric = (vscale * point_pressure + offset) * wJ;
    Coefficients c;
    c.ff = rank;
    c.fg = -(2.0 / 3.0) * stress - rank * third;
    c.gg = (2.0 / 3.0) * stress * third + rank * third * third + geometric;
    c.swap = stress * third - geometric;
    c.identity = stress;
    if constexpr (!mean_dilatation) c.gg += (vscale + share) * kappa * wJ * s.J;
    if constexpr (viscous) {
      c.spatial = share * stress * third;
      c.swap += c.spatial;
      c.gg -= (2.0 / 3.0) * c.spatial;
    }
    add_tangent<viscous>(rest.gradient[q], f, g, c, t.K);
  }
}

template <bool mean_dilatation, bool viscous>
void sweep_batch(const ElasticSweep& sweep, int batch) {
  const RestBatch& rest = sweep.batches[batch];
  const std::size_t first = static_cast<std::size_t>(batch) * lanes;
  Pack x[8][3];
  gather(sweep.positions, rest.corner, x);

  Totals t;
  for (int n = 0; n < 8; ++n)
    for (int i = 0; i < 3; ++i) t.volume_gradient[n][i] = splat(0.0);
  for (int k = 0; k < 36; ++k)
    for (int c = 0; c < 9; ++c) t.K[k][c] = splat(0.0);

  const Pack offset = mean_dilatation ? load(sweep.pressure_offset + first) : splat(0.0);
  integrate<mean_dilatation, viscous>(sweep, rest, x, load(sweep.isochoric_scale + first), load(sweep.pressure + first),
                                      offset, t);

  if constexpr (mean_dilatation) {
    const Pack bulk = (sweep.volumetric_scale * sweep.law.kappa) / load(rest.volume);
    int pair = 0;
    for (int b = 0; b < 8; ++b)
      for (int a = 0; a <= b; ++a, ++pair)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) t.K[pair][3 * i + j] += bulk * t.volume_gradient[a][i] * t.volume_gradient[b][j];
  }

  for (int lane = 0; lane < lanes; ++lane) {
    double* tangent = sweep.tangent + (first + static_cast<std::size_t>(lane)) * element_tangent_size;
    for (int k = 0; k < 36; ++k)
      for (int c = 0; c < 9; ++c) tangent[9 * k + c] = t.K[k][c][lane];
    double* volume = sweep.volume_gradient + (first + static_cast<std::size_t>(lane)) * volume_gradient_size;
    for (int n = 0; n < 8; ++n)
      for (int i = 0; i < 3; ++i) volume[3 * n + i] = t.volume_gradient[n][i][lane];
  }
}

}  // namespace

void sweep_tangents(const ElasticSweep& sweep, int begin, int end) {
  using Batch = void (*)(const ElasticSweep&, int);
  static constexpr Batch kinds[2][2] = {{sweep_batch<false, false>, sweep_batch<false, true>},
                                        {sweep_batch<true, false>, sweep_batch<true, true>}};
  const Batch kind = kinds[sweep.mean_dilatation ? 1 : 0][sweep.velocities ? 1 : 0];
  for (int batch = begin; batch < end; ++batch) kind(sweep, batch);
}

}  // namespace glossa::GLOSSA_KERNEL

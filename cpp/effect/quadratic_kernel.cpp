// Forces and tangents of four quadratic hexahedra at a time. Compiled once for each instruction set, with GLOSSA_KERNEL
// naming it; uses no library templates, so that no code of the wider instruction set can reach the rest of the program.
#include "effect/quadratic_kernel.hpp"

#include "core/pack.hpp"
#include "effect/tangent_point.hpp"

namespace glossa::GLOSSA_KERNEL {
namespace {

constexpr int nodes = 27, points = 27, octants = 8, functions = 4;

// Natural coordinate d of Gauss point q, and whether the point lies in octant o.
constexpr int step_of(int q, int d) {
  return d == 0 ? q % 3 - 1 : d == 1 ? q / 3 % 3 - 1 : q / 9 - 1;
}
constexpr double place(int q, int d) {
  return 0.7745966692414834 * step_of(q, d);
}
constexpr double half(int o, int d) {
  return (o >> d & 1) != 0 ? 0.5 : -0.5;
}
constexpr bool in_octant(int q, int o) {
  for (int d = 0; d < 3; ++d)
    if (step_of(q, d) * half(o, d) < 0.0) return false;
  return true;
}
// 1 / number of octants that a Gauss point lies in.
constexpr double share(int q) {
  double result = 1.0;
  for (int d = 0; d < 3; ++d)
    if (step_of(q, d) == 0) result *= 0.5;
  return result;
}

GLOSSA_ALWAYS_INLINE Pack at_point(const Pack coefficient[functions], int q) {
  return coefficient[0] + place(q, 0) * coefficient[1] + place(q, 1) * coefficient[2] + place(q, 2) * coefficient[3];
}

// The values of a field at the octants of four elements.
GLOSSA_ALWAYS_INLINE void read_octants(const double* field, const QuadraticBatch& rest, Pack value[octants]) {
  for (int o = 0; o < octants; ++o)
    for (int lane = 0; lane < lanes; ++lane) value[o][lane] = field[rest.octant[o][lane]];
}

GLOSSA_ALWAYS_INLINE void write_octants(const Pack value[octants], const QuadraticBatch& rest, double* field) {
  for (int o = 0; o < octants; ++o)
    for (int lane = 0; lane < lanes; ++lane) field[rest.octant[o][lane]] = value[o][lane];
}

// Coefficients of the linear function nearest to values at the octants' centres.
GLOSSA_ALWAYS_INLINE void fit(const Pack value[octants], Pack coefficient[functions]) {
  for (int m = 0; m < functions; ++m) coefficient[m] = splat(0.0);
  for (int o = 0; o < octants; ++o) {
    coefficient[0] += 0.125 * value[o];
    for (int d = 0; d < 3; ++d) coefficient[d + 1] += (0.5 * half(o, d)) * value[o];
  }
}

// Mean over the octants that the Gauss point lies in.
GLOSSA_ALWAYS_INLINE Pack mean(const Pack value[octants], int q) {
  Pack sum = splat(0.0);
  for (int o = 0; o < octants; ++o)
    if (in_octant(q, o)) sum += value[o];
  return share(q) * sum;
}

GLOSSA_ALWAYS_INLINE void project(const QuadraticBatch& rest, const Pack moment[functions],
                                  Pack coefficient[functions]) {
  for (int m = 0; m < functions; ++m) {
    coefficient[m] = splat(0.0);
    for (int n = 0; n < functions; ++n) coefficient[m] += load(rest.inverse_moment[m][n]) * moment[n];
  }
}

template <bool viscous>
void sweep_force_batch(const QuadraticSweep& sweep, int batch) {
  const QuadraticBatch& rest = sweep.batches[batch];
  const double c10 = sweep.law.c10, c20 = sweep.law.c20, kappa = sweep.law.kappa;
  Pack x[nodes][3], v[nodes][3];
  gather(sweep.positions, rest.corner, x);
  if constexpr (viscous) gather(sweep.velocities, rest.corner, v);

  Pack scale[octants], offset_value[octants], offset[functions];
  read_octants(sweep.isochoric_scale, rest, scale);
  read_octants(sweep.pressure_offset, rest, offset_value);
  fit(offset_value, offset);

  PointState state[points];
  Pack moment[functions], theta[functions], least[octants], isochoric[octants], volumetric[octants];
  for (int m = 0; m < functions; ++m) moment[m] = splat(0.0);
  for (int o = 0; o < octants; ++o) {
    least[o] = splat(1e300);
    isochoric[o] = volumetric[o] = splat(0.0);
  }
  for (int q = 0; q < points; ++q) {
    deform(rest.gradient[q], x, state[q]);
    const Pack wJ = load(rest.weight[q]) * state[q].J;
    moment[0] += wJ;
    for (int d = 0; d < 3; ++d) moment[d + 1] += place(q, d) * wJ;
    for (int o = 0; o < octants; ++o)
      if (in_octant(q, o)) least[o] = smaller(least[o], state[q].J);
  }
  project(rest, moment, theta);

  Pack force[nodes][4];
  for (int n = 0; n < nodes; ++n)
    for (int i = 0; i < 4; ++i) force[n][i] = splat(0.0);
  for (int q = 0; q < points; ++q) {
    const PointState& s = state[q];
    const Pack w = load(rest.weight[q]), wJ = w * s.J;
    const Pack cube = inverse_cube_root(s.J);
    const Pack a = cube * cube;
    const Pack i1 = a * s.trace - 3.0;
    const Pack slope = c10 + (2.0 * c20) * i1;
    const Pack third = s.trace * (1.0 / 3.0);
    const Pack point_scale = mean(scale, q);
    const Pack strain = at_point(theta, q) - 1.0;
    const Pack pressure = sweep.volumetric_scale * kappa * strain + at_point(offset, q);
    const Pack isochoric_share = share(q) * w * (c10 + c20 * i1) * i1,
               volumetric_share = share(q) * w * (0.5 * kappa) * strain * strain;
    for (int o = 0; o < octants; ++o)
      if (in_octant(q, o)) {
        isochoric[o] += isochoric_share;
        volumetric[o] += volumetric_share;
      }

    const Pack stress = point_scale * w * slope * 2.0 * a;
    Pack along_F = stress, spatial[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) spatial[i][j] = splat(0.0);
    if constexpr (viscous) {
      // `shear` is the coefficient of dev(D), `rank` that of (dI/dt) dI_a / (2 a)^2.
      const Pack shear = (2.0 * sweep.viscosity) * stress * third;
      const Pack rank = sweep.viscosity * point_scale * w * (8.0 * c20) * a * a;
      Pack rate[3][3], L[3][3], along = splat(0.0);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          rate[i][j] = splat(0.0);
          for (int n = 0; n < nodes; ++n) rate[i][j] += v[n][i] * load(rest.gradient[q][n][j]);
          along += rate[i][j] * s.F[i][j];
        }
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) L[i][j] = rate[i][0] * s.H[j][0] + rate[i][1] * s.H[j][1] + rate[i][2] * s.H[j][2];
      const Pack dilation = L[0][0] + L[1][1] + L[2][2];
      along_F += rank * (along - third * dilation);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) spatial[i][j] = 0.5 * shear * (L[i][j] + L[j][i]);
        spatial[i][i] -= (1.0 / 3.0) * shear * dilation;
      }
    }
    for (int i = 0; i < 3; ++i) spatial[i][i] += pressure * wJ - third * along_F;
    Pack P[3][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        P[i][k] =
            along_F * s.F[i][k] + spatial[i][0] * s.H[0][k] + spatial[i][1] * s.H[1][k] + spatial[i][2] * s.H[2][k];
    for (int n = 0; n < nodes; ++n) {
      const Pack G0 = load(rest.gradient[q][n][0]), G1 = load(rest.gradient[q][n][1]),
                 G2 = load(rest.gradient[q][n][2]);
      for (int i = 0; i < 3; ++i) force[n][i] += P[i][0] * G0 + P[i][1] * G1 + P[i][2] * G2;
    }
  }

  Pack dilatation[octants];
  for (int o = 0; o < octants; ++o)
    dilatation[o] = theta[0] + half(o, 0) * theta[1] + half(o, 1) * theta[2] + half(o, 2) * theta[3];
  write_octants(dilatation, rest, sweep.dilatation);
  write_octants(isochoric, rest, sweep.isochoric_energy);
  write_octants(volumetric, rest, sweep.volumetric_energy);
  write_octants(least, rest, sweep.least_jacobian);
  double* to = sweep.force + static_cast<std::size_t>(batch) * lanes * quadratic_force_size;
  for (int n = 0; n < nodes; ++n) {
    transpose(force[n][0], force[n][1], force[n][2], force[n][3]);
    for (std::size_t lane = 0; lane < lanes; ++lane)
      store(to + lane * quadratic_force_size + 4 * static_cast<std::size_t>(n), force[n][lane]);
  }
}

struct Totals {
  Pack moments[functions][nodes][3];
  Pack K[378][9];
};

template <bool viscous>
void sweep_tangent_batch(const QuadraticSweep& sweep, int batch) {
  const QuadraticBatch& rest = sweep.batches[batch];
  const double c10 = sweep.law.c10, c20 = sweep.law.c20, vscale = sweep.volumetric_scale;
  const double viscous_share = viscous ? sweep.viscous_share : 0.0;
  Pack x[nodes][3];
  gather(sweep.positions, rest.corner, x);
  Pack scale[octants], value[octants], offset[functions], pressure[functions];
  read_octants(sweep.isochoric_scale, rest, scale);
  read_octants(sweep.pressure_offset, rest, value);
  fit(value, offset);
  read_octants(sweep.pressure, rest, value);
  fit(value, pressure);

  Totals t;
  for (int m = 0; m < functions; ++m)
    for (int n = 0; n < nodes; ++n)
      for (int i = 0; i < 3; ++i) t.moments[m][n][i] = splat(0.0);
  for (int k = 0; k < 378; ++k)
    for (int c = 0; c < 9; ++c) t.K[k][c] = splat(0.0);

  for (int q = 0; q < points; ++q) {
    PointState s;
    deform(rest.gradient[q], x, s);
    const Pack w = load(rest.weight[q]), wJ = w * s.J;
    const Pack cube = inverse_cube_root(s.J);
    const Pack a = cube * cube;
    const Pack i1 = a * s.trace - 3.0;
    const Pack slope = c10 + (2.0 * c20) * i1;
    const Pack third = s.trace * (1.0 / 3.0);
    const Pack point_scale = mean(scale, q);
    const Pack stress = point_scale * w * slope * 2.0 * a;
    Pack f[nodes][3], g[nodes][3];
    for (int n = 0; n < nodes; ++n) {
      const Pack G0 = load(rest.gradient[q][n][0]), G1 = load(rest.gradient[q][n][1]),
                 G2 = load(rest.gradient[q][n][2]);
      for (int i = 0; i < 3; ++i) {
        f[n][i] = s.F[i][0] * G0 + s.F[i][1] * G1 + s.F[i][2] * G2;
        g[n][i] = s.H[i][0] * G0 + s.H[i][1] * G1 + s.H[i][2] * G2;
        const Pack b = wJ * g[n][i];
        t.moments[0][n][i] += b;
        for (int d = 0; d < 3; ++d) t.moments[d + 1][n][i] += place(q, d) * b;
      }
    }
    Pack rank = point_scale * w * (8.0 * c20) * a * a;  // W'' dI dI', dI_a = 2 a (f_a - t/3 g_a)
    if constexpr (viscous) rank *= 1.0 + viscous_share;
    const Pack geometric = (vscale * at_point(pressure, q) + at_point(offset, q)) * wJ;
    Coefficients c;
    c.ff = rank;
    c.fg = -(2.0 / 3.0) * stress - rank * third;
    c.gg = (2.0 / 3.0) * stress * third + rank * third * third + geometric;
    c.swap = stress * third - geometric;
    c.identity = stress;
    if constexpr (viscous) {
      c.spatial = viscous_share * stress * third;
      c.swap += c.spatial;
      c.gg -= (2.0 / 3.0) * c.spatial;
    }
    add_tangent<viscous>(rest.gradient[q], f, g, c, t.K);
  }

  const double bulk = vscale * sweep.law.kappa;
  int pair = 0;
  for (int b = 0; b < nodes; ++b) {
    Pack projected[functions][3];
    for (int m = 0; m < functions; ++m)
      for (int j = 0; j < 3; ++j) {
        projected[m][j] = splat(0.0);
        for (int n = 0; n < functions; ++n)
          projected[m][j] += bulk * load(rest.inverse_moment[m][n]) * t.moments[n][b][j];
      }
    for (int a = 0; a <= b; ++a, ++pair)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int m = 0; m < functions; ++m) t.K[pair][3 * i + j] += t.moments[m][a][i] * projected[m][j];
  }

  const std::size_t first = static_cast<std::size_t>(batch) * lanes;
  for (int lane = 0; lane < lanes; ++lane) {
    double* tangent = sweep.tangent + (first + static_cast<std::size_t>(lane)) * quadratic_tangent_size;
    for (int k = 0; k < 378; ++k)
      for (int c = 0; c < 9; ++c) *tangent++ = t.K[k][c][lane];
    double* moments = sweep.moments + (first + static_cast<std::size_t>(lane)) * quadratic_moment_size;
    for (int m = 0; m < functions; ++m)
      for (int n = 0; n < nodes; ++n)
        for (int i = 0; i < 3; ++i) *moments++ = t.moments[m][n][i][lane];
  }
}

}  // namespace

void sweep_quadratic_forces(const QuadraticSweep& sweep, int begin, int end) {
  const auto kind = sweep.velocities ? sweep_force_batch<true> : sweep_force_batch<false>;
  for (int batch = begin; batch < end; ++batch) kind(sweep, batch);
}

void sweep_quadratic_tangents(const QuadraticSweep& sweep, int begin, int end) {
  const auto kind = sweep.velocities ? sweep_tangent_batch<true> : sweep_tangent_batch<false>;
  for (int batch = begin; batch < end; ++batch) kind(sweep, batch);
}

}  // namespace glossa::GLOSSA_KERNEL

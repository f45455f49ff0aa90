// The inner loop of tissue elasticity for quadratic hexahedra: four at a time, one in each lane of a Pack.
//
// Q2/P1: 27 nodes (mesh/quadratic_hex.hpp) and a pressure that is linear in each element and may jump between them
// (Fortin 1981; Boffi & Gastaldi 2002: stable, second order in the pressure on meshes refined by division). With
// phi = (1, xi, eta, zeta), M_mn = Sum_g w phi_m phi_n and the projection of the volume ratio
//   theta = phi . c,   c = M^(-1) Sum_g w J phi,
// the energy of an element is  E = Sum_g w { s Wiso(F) + (kappa / 2)(theta - 1)^2 };  since the projection is
// orthogonal, d theta may be replaced by dJ in the force. In the notation of effect/elasticity_kernel.hpp, with
// p = kappa (theta - 1) at each of the 3 x 3 x 3 Gauss points and B_m,a = Sum_g w J phi_m g_a:
//   force    s Sum w W'(I) 2 a (f_a - (t/3) g_a) + Sum w p J g_a
//   tangent  as there, with p at each point, and kappa Sum_mn M^(-1)_mn B_m,a B_n,b' for (kappa / V) b_a b_b'
// The pressure of the geometric term, its offset, and the viscosity are as there.
//
// The body's hexahedra are the octants of these elements, and every quantity of an element crosses the rooms as one of
// its octants: a linear function is given by its values at the centres of the octants (its four coefficients follow by
// least squares); a Gauss point takes the mean stiffening of the octants it lies in and gives them its energy in
// equal shares.
#pragma once

#include <cstddef>

#include "core/index.hpp"
#include "core/lanes.hpp"
#include "material/yeoh.hpp"

namespace glossa {

/// Rest data of four quadratic hexahedra.
struct alignas(32) QuadraticBatch {
  double gradient[27][27][3][lanes];   ///< [Gauss point][node][direction][lane], 1/m
  double weight[27][lanes];            ///< m3
  double inverse_moment[4][4][lanes];  ///< M^(-1), 1/m3
  Index corner[27][lanes];             ///< node of the body
  Index octant[8][lanes];              ///< hexahedron of the body
};

inline constexpr std::size_t quadratic_force_size = 108;     ///< 27 nodes x 4, the fourth zero
inline constexpr std::size_t quadratic_moment_size = 324;    ///< 4 functions x 27 nodes x 3
inline constexpr std::size_t quadratic_tangent_size = 3402;  ///< 378 node pairs (a <= b) x 3 x 3

/// What one sweep over the elements reads and writes: per cell, padded to whole batches, or per octant (hexahedron of
/// the body).
struct QuadraticSweep {
  const QuadraticBatch* batches = nullptr;
  Yeoh law{};
  const double* positions = nullptr;        ///< current node positions, four doubles each, m
  const double* isochoric_scale = nullptr;  ///< per octant: s of eq. 1 times the scale of the stage
  double volumetric_scale = 1.0;            ///< scale of the volumetric part
  const double* pressure = nullptr;         ///< per octant: p of the geometric term (tangent only), Pa
  const double* pressure_offset = nullptr;  ///< per octant, Pa, added to the scaled pressure
  const double* velocities = nullptr;       ///< of the nodes, four doubles each, m/s; null without viscosity
  double viscosity = 0.0;                   ///< beta, s
  double viscous_share = 0.0;               ///< beta times d velocity / d position (tangent only)

  // Out, by sweep_quadratic_forces.
  double* force = nullptr;              ///< quadratic_force_size per cell, N
  double* dilatation = nullptr;         ///< theta at the centre of each octant
  double* isochoric_energy = nullptr;   ///< share of Sum_g w Wiso at s = 1 per octant, J
  double* volumetric_energy = nullptr;  ///< share per octant, J
  double* least_jacobian = nullptr;     ///< smallest J over the Gauss points of the octant
  // Out, by sweep_quadratic_tangents.
  double* tangent = nullptr;  ///< quadratic_tangent_size per cell, N/m
  double* moments = nullptr;  ///< B, quadratic_moment_size per cell, m2
};

/// Sweep the batches [begin, end). The widest instruction set of this processor is chosen at run time.
void sweep_quadratic_forces(const QuadraticSweep& sweep, int begin, int end);
void sweep_quadratic_tangents(const QuadraticSweep& sweep, int begin, int end);

namespace baseline {
void sweep_quadratic_forces(const QuadraticSweep& sweep, int begin, int end);
void sweep_quadratic_tangents(const QuadraticSweep& sweep, int begin, int end);
}  // namespace baseline
namespace avx2 {
void sweep_quadratic_forces(const QuadraticSweep& sweep, int begin, int end);
void sweep_quadratic_tangents(const QuadraticSweep& sweep, int begin, int end);
}  // namespace avx2

}  // namespace glossa

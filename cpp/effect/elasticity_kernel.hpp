// The inner loop of tissue elasticity: four hexahedra at a time, one in each lane of a Pack.
//
// Mean dilatation (Q1/P0; Nagtegaal, Parks & Rice 1974; Simo, Taylor & Pister 1985): the energy of an element is
//   E = s Sum_g w_g Wiso(F_g) + V U(theta),   theta = v / V = (1 / V) Sum_g w_g J_g,   U = (kappa / 2)(theta - 1)^2,
// so that only the mean volume is penalised and the element does not lock at nu = 0.499.
// With H = F^(-T), spatial gradients g_a = H G_a, f_a = F G_a and b_a = Sum_g w_g J_g g_a = dv/dx_a:
//   force    f_a  = s Sum w W'(I) 2 a (f_a - (t/3) g_a) + kappa (theta - 1) b_a,           a = J^(-2/3), t = tr F^T F
//   tangent  K_ab = s Sum w { W' 2 a [ (G_a.G_b) 1 - 2/3 (f_a g_b' + g_a f_b') + (2t/9) g_a g_b' + (t/3) g_b g_a' ]
//                             + W'' dI_a dI_b' } + p Sum w J (g_a g_b' - g_b g_a') + (kappa / V) b_a b_b'
// The pressure p of the geometric term is an unknown of its own (p = kappa (theta - 1) at convergence): taking it from
// the last linear prediction instead of the current dilatation is Newton's method on the mixed problem and keeps the
// tangent positive definite far from the solution.
// Plain Q1 puts the volumetric law at every Gauss point; it locks and serves for comparison.
//
// Viscosity: the material part of the isochoric tangent acts on the rate of deformation D, which rotations leave alone,
//   f_a += beta s Sum w { (4/3) W' a t dev(D) g_a + W'' (dI/dt) dI_a },
// so that its power, beta s Sum w { (4/3) W' a t |dev D|^2 + W'' (dI/dt)^2 }, is never negative. At rest it is beta K.
// Pressure gets its rate through `pressure_offset`: p = scale kappa (theta - 1) + offset; plain Q1 takes it from D.
#pragma once

#include <cstddef>

#include "core/index.hpp"
#include "core/lanes.hpp"
#include "material/yeoh.hpp"

namespace glossa {

/// Rest data of four hexahedra. Forces need the first four, tangents all but the metric.
struct alignas(32) RestBatch {
  double metric[8][6][lanes];       ///< [Gauss point]: (dX/dxi)^(-1) (dX/dxi)^(-T), 00 11 22 01 02 12, 1/m2
  double weight[8][lanes];          ///< m3
  double volume[lanes];             ///< m3
  Index corner[8][lanes];           ///< node of each corner
  double gradient[8][8][3][lanes];  ///< [Gauss point][corner][direction][lane], 1/m
};

inline constexpr std::size_t element_force_size = 32;     ///< 8 corners x 4, the fourth zero
inline constexpr std::size_t volume_gradient_size = 24;   ///< 8 corners x 3
inline constexpr std::size_t element_tangent_size = 324;  ///< 36 corner pairs (a <= b) x 3 x 3, row-major blocks

/// What one sweep over the elements reads and writes. Per-element arrays are padded to whole batches.
struct ElasticSweep {
  const RestBatch* batches = nullptr;
  Yeoh law{};
  bool mean_dilatation = true;
  const double* positions = nullptr;        ///< current node positions, four doubles each, m
  const double* isochoric_scale = nullptr;  ///< per element: s of eq. 1 times the scale of the stage
  double volumetric_scale = 1.0;            ///< scale of the volumetric part
  const double* pressure = nullptr;         ///< per element: p of the geometric term (tangent only), Pa
  const double* pressure_offset = nullptr;  ///< per element, Pa, added to the scaled pressure (mean dilatation only)
  const double* velocities = nullptr;       ///< of the nodes, four doubles each, m/s; null without viscosity
  double viscosity = 0.0;                   ///< beta, s
  double viscous_share = 0.0;               ///< beta times d velocity / d position (tangent only)

  // Out, by sweep_forces.
  double* force = nullptr;              ///< element_force_size per element, N
  double* dilatation = nullptr;         ///< theta per element
  double* isochoric_energy = nullptr;   ///< Sum_g w Wiso at s = 1 per element, J
  double* volumetric_energy = nullptr;  ///< J
  double* least_jacobian = nullptr;     ///< smallest J over the Gauss points per element
  // Out, by sweep_tangents.
  double* tangent = nullptr;          ///< element_tangent_size per element, N/m
  double* volume_gradient = nullptr;  ///< b = dv/dx, volume_gradient_size per element, m2
};

/// Sweep the batches [begin, end). The widest instruction set of this processor is chosen at run time.
void sweep_forces(const ElasticSweep& sweep, int begin, int end);
void sweep_tangents(const ElasticSweep& sweep, int begin, int end);

namespace baseline {
void sweep_forces(const ElasticSweep& sweep, int begin, int end);
void sweep_tangents(const ElasticSweep& sweep, int begin, int end);
}  // namespace baseline
namespace avx2 {
void sweep_forces(const ElasticSweep& sweep, int begin, int end);
void sweep_tangents(const ElasticSweep& sweep, int begin, int end);
}  // namespace avx2

}  // namespace glossa

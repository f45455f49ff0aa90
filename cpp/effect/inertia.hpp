// Inertia and the mass-proportional part of Rayleigh damping (eq. 6), with the consistent mass matrix.
// The stiffness-proportional part is carried by the tissue's viscosity (effect/elasticity_kernel.hpp) or by the
// momentum form of the time integrator (solver/integrator.hpp).
#pragma once

#include "bone/bone.hpp"
#include "effect/effect.hpp"

namespace glossa {

/// Which part of the tissue's tangent damps.
enum class DampingLaw {
  material,  ///< the material part, on the rate of deformation: never feeds energy
  tangent,   ///< all of it, stress stiffness included: feeds energy where it is not positive definite
};

/// Rayleigh damping C = alpha M + beta K of eq. 6. K belongs to the tissue (elements with their stiffening), not to
/// muscles or supports.
struct RayleighDamping {
  double alpha = 40.0;  ///< 1/s
  double beta = 0.03;   ///< s
  DampingLaw law = DampingLaw::material;

  /// beta of the momentum w = M v + beta f.
  [[nodiscard]] double in_momentum() const { return law == DampingLaw::tangent ? beta : 0.0; }
  /// beta of the viscosity of the tissue.
  [[nodiscard]] double viscosity() const { return law == DampingLaw::material ? beta : 0.0; }
};

/// Adds mass_rate M V. Its tangent is part of BlockMatrix::gather.
class Inertia final : public Effect {
 public:
  Inertia(const Cells& elements, Index node_count, const std::vector<double>& element_masses,
          const std::vector<PointMass>& points = {});

  [[nodiscard]] const char* name() const override { return "inertia"; }
  void add_force(const Trial& trial, NodeField& force) override;
  void add_tangent(const Trial&, BlockMatrix&) override {}
  [[nodiscard]] double energy(const Trial&) const override { return 0.0; }

  /// Adds scale M x to `product`.
  void multiply(double scale, const NodeField& x, NodeField& product) const;

 private:
  std::vector<Index> row_start_, column_;  // full symmetric pattern of the nodes
  std::vector<double> mass_;
};

}  // namespace glossa

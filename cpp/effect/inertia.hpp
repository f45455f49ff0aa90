// Inertia and the mass-proportional part of Rayleigh damping (eq. 6), with the consistent mass matrix.
// The stiffness-proportional part is carried by the momentum form of the time integrator.
#pragma once

#include "bone/bone.hpp"
#include "effect/effect.hpp"

namespace glossa {

/// Rayleigh damping C = alpha M + beta K of eq. 6. K is the current tangent of the tissue (elements with their
/// stiffening), not of muscles or supports.
struct RayleighDamping {
  double alpha = 40.0;  ///< 1/s
  double beta = 0.03;   ///< s
};

/// Adds mass_rate M V. Its tangent is part of BlockMatrix::gather.
class Inertia final : public Effect {
 public:
  Inertia(const std::vector<Hexahedron>& elements, Index node_count, const std::vector<double>& element_masses,
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

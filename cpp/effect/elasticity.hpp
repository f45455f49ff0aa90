// Hyperelastic tissue: the elements' forces and tangents.
#pragma once

#include <memory>

#include "effect/effect.hpp"
#include "effect/elasticity_kernel.hpp"
#include "mesh/hex_mesh.hpp"

namespace glossa {

enum class ElementKind {
  q1p0,  ///< trilinear displacement, one pressure per element (mean dilatation)
  q1,    ///< trilinear displacement, volumetric law at every Gauss point: locks, for comparison
};

/// Reference gradients and weights of all elements, in batches of four; shared between scenes of one mesh.
using RestBatches = std::vector<RestBatch>;
[[nodiscard]] std::shared_ptr<const RestBatches> rest_batches(const HexMesh& mesh);

/// Packed consistent element masses (36 corner pairs a <= b per element, kg) for a density in kg/m3.
[[nodiscard]] std::vector<double> element_masses(const HexMesh& mesh, double density);

class Elasticity final : public Effect {
 public:
  Elasticity(const HexMesh& mesh, std::shared_ptr<const RestBatches> batches, Yeoh law, ElementKind kind, int threads);

  [[nodiscard]] const char* name() const override { return "elasticity"; }
  void add_force(const Trial& trial, NodeField& force) override;
  /// Element tangents at the trial; they are gathered by tangents(), which must come first in an assembly.
  void add_tangent(const Trial& trial, BlockMatrix& matrix) override;
  [[nodiscard]] double energy(const Trial& trial) const override;

  /// K x for a node field x of all components, with the element tangents of the last add_tangent.
  void multiply(const NodeField& x, NodeField& product) const;
  /// Moves the pressures of the geometric stiffness a fraction `step` towards their linear prediction
  ///   kappa (theta - 1) + (kappa / V) b . dx
  /// for the displacement increment dx (m), with theta of the last sweep and b of the last add_tangent. This is the
  /// pressure update of Newton's method on the mixed problem.
  void predict_pressure(const NodeField& dx, double step, std::vector<double>& pressure) const;
  /// Sets the pressures to those of the last sweep, kappa (theta - 1).
  void set_pressure(std::vector<double>& pressure) const;
  /// Scale of the mass added to the gathered blocks (1/s2), set by the owner before add_tangent.
  void set_mass_scale(double scale) { mass_scale_ = scale; }

  [[nodiscard]] std::size_t padded_count() const { return batches_->size() * lanes; }
  [[nodiscard]] const std::vector<double>& dilatation() const { return dilatation_; }
  [[nodiscard]] double least_jacobian() const;
  [[nodiscard]] Index worst_element() const;
  [[nodiscard]] const Yeoh& law() const { return law_; }
  /// Isochoric energy at s = 1 of each element (J).
  [[nodiscard]] const std::vector<double>& isochoric_energy() const { return isochoric_energy_; }
  [[nodiscard]] const std::vector<double>& volumetric_energy() const { return volumetric_energy_; }

 private:
  ElasticSweep sweep(const Trial& trial);
  void spread(const NodeField& field, std::vector<double>& four) const;

  const HexMesh& mesh_;
  std::shared_ptr<const RestBatches> batches_;
  Yeoh law_;
  ElementKind kind_;
  int threads_;
  double mass_scale_ = 0.0;
  std::vector<Index> source_start_;             // per node: its corners in elements
  std::vector<Index> source_;                   // 8 e + a
  std::vector<double> no_offset_;               // zeros
  std::vector<double> positions_, velocities_;  // of the last sweep, four doubles for each node
  std::vector<double> force_, tangent_, volume_gradient_, dilatation_, isochoric_energy_, volumetric_energy_,
      least_jacobian_;
};

}  // namespace glossa

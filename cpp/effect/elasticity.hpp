// Hyperelastic tissue: the elements' forces and tangents.
#pragma once

#include <memory>

#include "effect/effect.hpp"
#include "effect/elasticity_kernel.hpp"
#include "effect/quadratic_kernel.hpp"
#include "mesh/hex_mesh.hpp"

namespace glossa {

enum class ElementKind {
  q1p0,  ///< trilinear displacement, one pressure per element (mean dilatation)
  q1,    ///< trilinear displacement, volumetric law at every Gauss point: locks, for comparison
  q2p1,  ///< triquadratic displacement on groups of eight hexahedra, discontinuous linear pressure
};

/// The elements at rest: their nodes, and reference gradients and weights in batches of four; shared between scenes of
/// one mesh. Either the hexahedra of the mesh or the quadratic cells they form.
struct RestBatches {
  Cells cells;
  std::vector<RestBatch> linear;
  std::vector<QuadraticBatch> quadratic;

  [[nodiscard]] bool is_quadratic() const { return !quadratic.empty(); }
  [[nodiscard]] std::size_t count() const { return is_quadratic() ? quadratic.size() : linear.size(); }
};
/// InputError if quadratic cells are asked for and the mesh cannot be grouped.
[[nodiscard]] std::shared_ptr<const RestBatches> rest_batches(const HexMesh& mesh,
                                                              ElementKind kind = ElementKind::q1p0);

/// Packed consistent masses of the mesh's hexahedra (36 corner pairs a <= b for each, kg) for a density in kg/m3.
[[nodiscard]] std::vector<double> element_masses(const HexMesh& mesh, double density);
/// The same of the elements that `rest` consists of.
[[nodiscard]] std::vector<double> element_masses(const HexMesh& mesh, const RestBatches& rest, double density);

/// Element quantities (dilatation, pressure, stiffening, energies) belong to the hexahedra of the mesh, whatever the
/// elements: quadratic ones give and take them at their octants (effect/quadratic_kernel.hpp).
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
  ///   kappa (theta - 1) + (kappa / V) b . dx    (of quadratic elements: + kappa phi . M^(-1) B . dx)
  /// for the displacement increment dx (m), with theta of the last sweep and b of the last add_tangent. This is the
  /// pressure update of Newton's method on the mixed problem.
  void predict_pressure(const NodeField& dx, double step, std::vector<double>& pressure) const;
  /// Sets the pressures to those of the last sweep, kappa (theta - 1).
  void set_pressure(std::vector<double>& pressure) const;
  /// Scale of the mass added to the gathered blocks (1/s2), set by the owner before add_tangent.
  void set_mass_scale(double scale) { mass_scale_ = scale; }

  [[nodiscard]] std::size_t padded_count() const { return padded_; }
  [[nodiscard]] const std::vector<double>& dilatation() const { return dilatation_; }
  [[nodiscard]] double least_jacobian() const;
  [[nodiscard]] Index worst_element() const;
  [[nodiscard]] const Yeoh& law() const { return law_; }
  /// Isochoric energy at s = 1 of each element (J).
  [[nodiscard]] const std::vector<double>& isochoric_energy() const { return isochoric_energy_; }
  [[nodiscard]] const std::vector<double>& volumetric_energy() const { return volumetric_energy_; }

 private:
  ElasticSweep sweep(const Trial& trial);
  QuadraticSweep quadratic_sweep(const Trial& trial);
  void predict_quadratic(const NodeField& dx, double step, std::vector<double>& pressure) const;
  void spread(const NodeField& field, std::vector<double>& four) const;

  const HexMesh& mesh_;
  std::shared_ptr<const RestBatches> batches_;
  Yeoh law_;
  ElementKind kind_;
  int threads_;
  std::size_t padded_;  // hexahedra of the mesh, in whole batches
  double mass_scale_ = 0.0;
  std::vector<Index> source_start_;                        // per node: its places in cells
  std::vector<Index> source_;                              // nodes of a cell times cell + place
  std::vector<double> no_offset_;                          // zeros
  std::vector<double> positions_, velocities_;             // of the last sweep, four doubles for each node
  std::vector<double> force_, tangent_, volume_gradient_;  // the last: moments of quadratic elements
  std::vector<double> dilatation_, isochoric_energy_, volumetric_energy_, least_jacobian_;
};

}  // namespace glossa

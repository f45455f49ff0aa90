// Macrofibres pull: eqs. 2, 3 and 5.
#pragma once

#include "effect/effect.hpp"
#include "muscle/force_law.hpp"
#include "muscle/macrofibre.hpp"

namespace glossa {

/// Uniform tension T = rho_f level(A) factor(v) along each polyline; T dl/dx on its nodes.
///
/// Where the activation follows the trial (statics, no delay), its length dependence enters the tangent; its
/// dependence on the rate of length does not (it is small and the tangent stays symmetric and positive).
class MuscleForce final : public Effect {
 public:
  MuscleForce(const Macrofibres& fibres, const ForceLaw& law);

  [[nodiscard]] const char* name() const override { return "muscles"; }
  /// The fibres that are coupled: their node groups for the layout of the matrix.
  [[nodiscard]] const Rows<Index>& couplings() const { return fibres_.nodes; }
  /// Looks up where the blocks of the fibres lie in `matrix`; call once for each layout. With `stretch` false the
  /// tangent goes without the fibres' stiffness to stretch, which couples all nodes of a fibre, and only neighbours
  /// on a fibre need blocks.
  void bind(const BlockMatrix& matrix, bool stretch = true);

  /// Motor commands of the fibres (m), used where the activation follows the trial.
  void set_lambda(std::vector<double> lambda) { lambda_ = std::move(lambda); }
  /// Lengths and rates at the trial state and, where the activation follows it, the activations (into trial).
  void measure(Trial& trial);

  void add_force(const Trial& trial, NodeField& force) override;
  void add_tangent(const Trial& trial, BlockMatrix& matrix) override;
  [[nodiscard]] double energy(const Trial& trial) const override;
  /// K x of the last add_tangent, as Elasticity::multiply, added to `product`.
  void multiply(const Trial& trial, const NodeField& x, NodeField& product) const;

  /// dT / dl of a fibre (N/m) at the trial of the last measure() and its stretch dl / dx on its nodes: the stiffness
  /// to stretch is their product g g'. 0 where the fibre is slack.
  double stretch(const Trial& trial, Index fibre, std::vector<Vector3>& gradient) const;
  [[nodiscard]] const std::vector<double>& lengths() const { return length_; }
  [[nodiscard]] const std::vector<double>& tensions() const { return tension_; }  ///< N, of the last add_force

 private:
  // First node of a fibre that its node b is coupled with.
  [[nodiscard]] Index first_coupled(Index b) const { return stretch_ || b == 0 ? 0 : b - 1; }
  [[nodiscard]] double axial_stiffness(const Trial& trial, std::size_t f) const;

  const Macrofibres& fibres_;
  ForceLaw law_;
  std::vector<double> lambda_, length_, rate_, tension_;
  bool stretch_ = true;
  std::vector<Index> slot_start_;
  std::vector<BlockMatrix::Slot> slots_;
  std::vector<Vector3> gradient_;
  std::vector<Matrix3> bend_;  // tension times curvature of each segment
};

}  // namespace glossa

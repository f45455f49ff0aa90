// What every effect of a scene is: something that adds a force, and its derivative, at a trial state.
//
// Sign convention, for all effects: an effect adds the gradient of its potential, that is the force with which the
// body *resists* or, for loads, minus the load. The body is in equilibrium where the sum over all effects vanishes at
// the free components; at held components the sum is the force of the support on the body.
#pragma once

#include "effect/block_matrix.hpp"

namespace glossa {

/// The state at which effects are evaluated, and how a time integrator weighs them.
///
/// Statics: velocities zero, velocity_share 0, elastic_share 1. In a stage of a time step with u' = V = (u - ub) / hg
/// (solver/integrator.hpp), V depends on u with velocity_share = 1 / hg and the inertial term is (1 / hg + alpha) M V.
/// Damping by the tangent: elastic forces carry 1 + beta / hg. Damping by the material: the tissue is viscous, and its
/// pressure p(u) + beta (p(u) - pb) / hg.
struct Trial {
  NodeField positions;                  ///< m
  NodeField velocities;                 ///< m/s
  double velocity_share = 0.0;          ///< dV/du, 1/s
  double elastic_share = 1.0;           ///< factor of the pressure; loads are judged by it
  double mass_rate = 0.0;               ///< factor of M V, 1/s
  double viscosity = 0.0;               ///< beta of the material's damping, s
  std::vector<double> isochoric_scale;  ///< per element, padded to whole batches: s, or (1 + beta / hg) s - beta s'
  std::vector<double> pressure_offset;  ///< per element, padded: - beta pb / hg, Pa; empty: 0
  std::vector<double> pressure;         ///< per element, padded: p of the geometric stiffness, Pa
  std::vector<double> activation;       ///< per fibre, m
  bool activation_follows = true;       ///< activation depends on the trial lengths (undelayed), not on the past
  double rate_gain = 0.0;               ///< mu of eq. 2 where the activation follows, s
};

class Effect {
 public:
  Effect() = default;
  Effect(const Effect&) = delete;
  Effect& operator=(const Effect&) = delete;
  virtual ~Effect() = default;

  /// Name in Scene.effects and in the cost table.
  [[nodiscard]] virtual const char* name() const = 0;
  /// Adds its force (N, node field) at the trial state. May keep what add_tangent needs.
  virtual void add_force(const Trial& trial, NodeField& force) = 0;
  /// Adds its symmetric tangent at the trial state; `matrix` has just been gathered or added to by earlier effects.
  virtual void add_tangent(const Trial& trial, BlockMatrix& matrix) = 0;
  /// Potential energy (J) at the trial state of the last add_force, stiffening factors held; 0 if there is none.
  [[nodiscard]] virtual double energy(const Trial& trial) const = 0;
};

}  // namespace glossa

// Small movements of a scene about an equilibrium: its equation of motion with the delayed reflex, linearised.
//
// With unknowns q counted from the equilibrium and the activations of the active fibres,
//   M q'' + C q' + K q + Sum_f b_f a_f = 0,   a_f(t) = g_f . [q(t - d) + mu q'(t - d)]   (eq. 2 where it is positive).
// M: consistent mass, that of the bone included. C: alpha M, the damping of the tissue (effect/elasticity_kernel.hpp;
// beta times its whole tangent for damping by the tangent), and the force-velocity slope of the fibres (eq. 5). K: the
// tangent with activations held. b_f: derivative of the forces with respect to the activation of fibre f, by its
// tension (eq. 3) and by the stiffening of the tissue (eq. 1). g_f: derivative of its length. Points that touch a wall
// stick to it: what moves little does not use up the slip of a friction spring.
#pragma once

#include "scene/system.hpp"

namespace glossa {

/// What an equilibrium consists of beside its motor commands.
struct RestState {
  NodeField positions;                   ///< m
  std::vector<double> contact_pressure;  ///< Pa, of each contact point; empty: nothing touches
  std::vector<Vector3> contact_drag;     ///< Pa; empty: none
  std::vector<Vector3> wall_shift;       ///< m; empty: none
};

class LinearMotion {
 public:
  /// `fractions`: motor commands, one per muscle, NaN where silent. InputError where sizes do not fit.
  LinearMotion(const Scene& scene, const std::vector<bool>& commanded, const std::vector<double>& fractions,
               RestState rest);

  /// K + rate C + acceleration M, lower triangle; rate in 1/s, acceleration in 1/s2.
  const LowerColumns& matrix(double rate, double acceleration);
  /// Flat component 3 n + i of every unknown.
  [[nodiscard]] const std::vector<Index>& unknowns() const { return system_.component_of_unknown(); }
  /// Fibres of the scene whose activation is positive.
  [[nodiscard]] const std::vector<Index>& active() const { return active_; }
  /// Activations of the active fibres in the equilibrium, m.
  [[nodiscard]] std::vector<double> activation() const;
  /// b of every active fibre, one after another, N/m.
  [[nodiscard]] std::vector<double> pulls();
  /// g of every active fibre, one after another.
  [[nodiscard]] std::vector<double> gradients();

  /// Node field of increments of the unknowns, tied nodes to first order.
  [[nodiscard]] NodeField spread(const Vector& increment) const {
    return system_.spread(increment, 1.0, rest_.positions);
  }

  /// The forces themselves (N, at the unknowns) but for M q'', at a displacement (m), a velocity (m/s) and activations
  /// (m) of the active fibres: what the matrices are derivatives of. Small displacements: something must still touch
  /// where something touches, because the numbering depends on it.
  [[nodiscard]] Vector force(const Vector& displacement, const Vector& velocity, const std::vector<double>& activation);

 private:
  void hold_contact(const RestState& rest);
  void evaluate(const Trial& trial);
  [[nodiscard]] double share(double rate) const;

  System system_;
  Trial rest_;              // at the equilibrium, activations held
  std::vector<Index> own_;  // active fibres in the numbering of the system
  std::vector<Index> active_;
  NodeField force_;
};

}  // namespace glossa

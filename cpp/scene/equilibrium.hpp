// Static equilibrium of a scene under motor commands, loads and prescribed displacements.
//
// With the stiffening factors of eq. 1 held, every static effect has a potential. Each Newton iteration minimises that
// potential (Armijo line search on the energy, no inverted element), then lets the factors follow the activations;
// their influence is a weak contraction (spectral radius 0.02 .. 0.2). Near the solution the factor is frozen and an
// Anderson quasi-Newton iteration on the full residual, factors following, finishes: it costs one residual and one
// solve where a Newton iteration costs a factorisation. If this does not converge, the factors are held until the
// energy is minimised and updated in an outer loop.
//
// Contact joins as an augmented Lagrangian: its multipliers are held in each solve, take the pressures found, and the
// solve goes on from there with the same factor, until gaps and pressures obey the laws of contact. Friction opposes
// the slip since rest: the posture is reached from rest in one increment, whatever the solve starts from. Its bounds
// are held while the residual is large, so that there is an energy to minimise, and follow the pressures, as the
// stiffening factors follow the activations, once it is small; if this does not converge, they join the multipliers.
// The concave part of the walls' curvature stays out of the factor until the residual is small: it makes every fourth
// tangent on the way indefinite and shortens no way.
#pragma once

#include "scene/system.hpp"

namespace glossa {

struct EquilibriumOptions {
  double tolerance = 1e-8;        ///< residual over force scale
  int max_iterations = 150;       ///< Newton iterations of each minimisation
  double max_step = 0.055;        ///< largest displacement component of one iteration over the extent of the body
  bool quasi_newton = true;       ///< finish with frozen factors
  double gap_tolerance = 4.5e-5;  ///< m, deepest penetration of a wall, widest gap that still pushes
  int max_contact_updates = 80;
  std::vector<Vector3> wall_start, wall_shift;  ///< m, displacement of each wall at first and at last
  std::vector<double> contact_start;            ///< Pa, of each contact point at the start; empty: none presses
  Interrupt interrupt;
};

struct Equilibrium {
  Report report;
  NodeField positions;                   ///< m
  std::vector<double> pressure;          ///< Pa, per element
  std::vector<double> stiffening;        ///< s_e per element
  std::vector<double> activation;        ///< m, per fibre of the scene (0 where not commanded)
  std::vector<double> tension;           ///< N, per fibre of the scene
  NodeField force;                       ///< N, sum of all effects: the support's force at held components
  std::vector<double> contact_pressure;  ///< Pa, of each contact point
  std::vector<Vector3> contact_drag;     ///< Pa, friction of the body on the wall at each contact point
};

/// Solves from `start` (positions of all nodes; element pressures may be empty). Held components of `start` that
/// differ from `target` are moved there in as few increments as keep every element uninverted. Where `start` is an
/// equilibrium, the pressures of its contact points carry the state of its contact, and the solve ends where it begins.
/// Never throws for numerical failure: the report says how it ended and the state is the last good one.
[[nodiscard]] Equilibrium equilibrate(System& system, const NodeField& start, const std::vector<double>& pressure,
                                      const NodeField& target, const EquilibriumOptions& options);

}  // namespace glossa

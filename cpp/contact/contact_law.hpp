// Unilateral contact as an augmented Lagrangian (Simo & Laursen 1992) and Coulomb friction with elastic slip, per unit
// of area.
//
// The penalty grows progressively, so that a penetration stays below 0.05 mm whatever the pressure, with one potential
// for good: no update is needed, and none disturbs a movement. The multiplier is kept as the advance of the wall, the
// depth whose pressure it is; it takes over where bodies or pressures are beyond the penalty.
//
// With advance and friction bounds held, pressure and friction derive from convex potentials of gap and slip. The
// bound is the coefficient times the pressure of the last update, not the present one (Tresca friction at each solve,
// Coulomb when pressures have settled): the tangent is then symmetric and every solve a minimisation, which a
// consistent Coulomb tangent, unsymmetric, would not allow. Sticking points give way by bound / stiffness, some
// micrometres.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/types.hpp"

namespace glossa {

struct ContactLaw {
  double stiffness = 0.0;             ///< Pa/m, of a shallow penetration
  double deepest = 4.5e-5;            ///< m, penetration that the law approaches and all but never reaches
  double tangential_stiffness = 0.0;  ///< Pa/m, of the slip before it slides
  double friction = 0.0;              ///< Coulomb's coefficient

  /// Pressure (Pa) at a depth (m): k d / (1 - d / deepest), linear with its last slope beyond 0.8 of the deepest.
  [[nodiscard]] double pressure(double depth) const {
    if (depth <= 0.0) return 0.0;
    const double limit = 0.8 * deepest;
    if (depth <= limit) return stiffness * depth / (1.0 - depth / deepest);
    return 5.0 * stiffness * limit + 25.0 * stiffness * (depth - limit);
  }
  /// The depth (m) of a pressure; 0 where there is none.
  [[nodiscard]] double depth(double given) const {
    if (given <= 0.0) return 0.0;
    const double limit = 0.8 * deepest, last = 5.0 * stiffness * limit;
    return given <= last ? given / (stiffness + given / deepest) : limit + (given - last) / (25.0 * stiffness);
  }
  /// d pressure / d depth, Pa/m.
  [[nodiscard]] double slope(double depth) const {
    if (depth <= 0.0) return 0.0;
    const double rest = std::max(0.2, 1.0 - depth / deepest);
    return stiffness / (rest * rest);
  }
  /// Integral of the pressure over the depth, J/m2.
  [[nodiscard]] double energy(double depth) const {
    if (depth <= 0.0) return 0.0;
    const double limit = 0.8 * deepest, share = std::min(depth, limit) / deepest;
    const double smooth = stiffness * deepest * deepest * (-std::log1p(-share) - share);
    const double beyond = std::max(0.0, depth - limit);
    return smooth + beyond * (5.0 * stiffness * limit + 12.5 * stiffness * beyond);
  }

  /// Traction (Pa) after a slip (m, tangential) from a state of traction `before`, before the bound.
  [[nodiscard]] Vector3 trial_traction(const Vector3& before, const Vector3& slip) const {
    return before + tangential_stiffness * slip;
  }
  /// The trial traction brought back to the bound (Pa): gradient of the friction potential with respect to the slip.
  [[nodiscard]] static Vector3 bounded(const Vector3& trial, double bound) {
    const double size = trial.norm();
    return size <= bound ? trial : Vector3(trial * (bound / size));
  }
  /// Potential (J/m2) of that traction.
  [[nodiscard]] double friction_energy(const Vector3& trial, double bound) const {
    const double size = trial.norm();
    return (size <= bound ? 0.5 * size * size : bound * (size - 0.5 * bound)) / tangential_stiffness;
  }
  /// Derivative of the bounded traction with respect to the slip, in the tangent plane of projector `tangential`.
  [[nodiscard]] Matrix3 friction_slope(const Vector3& trial, double bound, const Matrix3& tangential) const {
    const double size = trial.norm();
    if (size <= bound) return tangential_stiffness * tangential;
    const Vector3 along = trial / size;
    return tangential_stiffness * bound / size * (tangential - along * along.transpose());
  }
};

}  // namespace glossa

// Time integration of the damped body (eq. 6 with C = alpha M + beta K, K of the tissue) by methods whose stages are of
// one form: with known bases ub, wb, pb and hg,
//   V = (u - ub) / hg,   (1/hg + alpha) M V + f_damped(u, V) + g(u, V, t) - wb / hg = 0,
// f being the tissue's force with the stiffening factors s_e and g all other forces.
//
// Damping by the material (default): w = M v; the tissue is a Kelvin-Voigt solid. To its isochoric stress comes
// beta s c : D, with c the material part of the isochoric tangent and D the rate of deformation
// (effect/elasticity_kernel.hpp); to the pressure p of an element beta p', p' = (p(u) - pb) / hg, which is exact for
// the volume where beta kappa div v would drift. The power of this damping is never negative.
//
// Damping by the tangent: K is the whole tangent, stress stiffness included. The damping term of eq. 6 is
//   K(u, s) v = df/dt - Sum_e s_e' f_e(u),   f_e: isochoric force of element e at s = 1,
// so that with w = M v + beta f(u, s) eq. 6 is, exactly and without forming K v,
//   w' = -alpha M v - f - g + beta Sum_e s_e' f_e,
// and f_damped = (1 + beta/hg) f - beta Sum s_e' f_e. A lagged beta K v instead drifts in volume and is wrong by
// millimetres during movement. Where strong compression makes K indefinite (least eigenvalue of /i/ on the built-in
// speaker, pressed against its walls: -50 N/m on nodes of 0.1 g) this damping feeds energy: vibrations that contact and
// muscles hold in place grow within milliseconds if the steps resolve them, and the movement of /a/ ends at 0.23 s.
// The two laws agree at rest; in movements of the vowels the tongue is up to 0.8 mm elsewhere (0.04 to 0.1 mm rms after
// 100 ms).
//
// sdirk2 (default): two stages, gamma = 1 - 1/sqrt 2 (Alexander 1977), stiffly accurate, L-stable, self-starting.
// bdf2: one stage, variable step, started by sdirk2. backward_euler: first order, for rescue and comparison.
// trapezoidal: energy conserving and not damped at high frequency; for comparison with other codes only: it rings, and
// is first order with muscles.
#pragma once

#include <string>

#include "core/types.hpp"

namespace glossa {

enum class Integrator { sdirk2, bdf2, backward_euler, trapezoidal };

inline constexpr double sdirk2_gamma = 0.29289321881345247559915563789515;

/// Share of the trapezoid defect |u1 - u0 - h/2 (v0 + v1)| that estimates the local error of each method: chosen so
/// that the errors of the steps, added up, are those of movements of the vowels within a factor of two.
[[nodiscard]] constexpr double defect_share(Integrator method) {
  switch (method) {
    case Integrator::sdirk2:
      return 0.6;
    case Integrator::bdf2:
      return 1.25;
    case Integrator::backward_euler:
      return 1.0;
    case Integrator::trapezoidal:
      return 0.25;
  }
  return 1.0;
}

/// Weights of a variable-step BDF2 for the ratio omega = step / last step:
/// base = present * a - last * b, hg = step * c.
struct Bdf2 {
  double a, b, c;
  explicit constexpr Bdf2(double omega)
      : a((1.0 + omega) * (1.0 + omega) / (1.0 + 2.0 * omega)),
        b(omega * omega / (1.0 + 2.0 * omega)),
        c((1.0 + omega) / (1.0 + 2.0 * omega)) {}
};

}  // namespace glossa

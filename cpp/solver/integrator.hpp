// Time integration of the damped body in momentum form.
//
// With f(u, s) the tissue's force and s_e the stiffening factors of eq. 1, the damping term of eq. 6 is
//   K(u, s) v = df/dt - Sum_e s_e' f_e(u),   f_e: isochoric force of element e at s = 1,
// so that eq. 6 with C = alpha M + beta K is, exactly and without forming K v,
//   u' = v,   w = M v + beta f(u, s),   w' = -alpha M v - f - g + beta Sum_e s_e' f_e,
// g being all other forces. Every method below has stages of one form: with known ub, wb and hg,
//   V = (u - ub) / hg,   (1/hg + alpha) M V + (1 + beta/hg) f(u) + g(u, V, t) - beta Sum s_e' f_e - wb / hg = 0.
// A lagged beta K v instead drifts in volume and is wrong by millimetres during movement.
//
// K is the tangent of the tissue alone. Where strong compression makes it indefinite (least eigenvalue of /i/ on the
// built-in speaker, pressed against its walls: -50 N/m on nodes of 0.1 g), damping by it feeds energy into modes that
// contact and muscles hold in place: vibrations near 1 kHz grow within milliseconds if the steps resolve them (BDF2
// below 0.5 ms, sdirk2 below 2 ms there), and longer steps damp them.
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

/// Share of the trapezoid defect |u1 - u0 - h/2 (v0 + v1)| that estimates the local error of each method, from
/// comparison with true local errors: 1/4 for sdirk2 (whose defect overstates), 1.25 for bdf2.
[[nodiscard]] constexpr double defect_share(Integrator method) {
  switch (method) {
    case Integrator::sdirk2:
      return 0.25;
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

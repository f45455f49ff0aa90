// From activation to force: eqs. 3 and 5 of Buchaillard, Perrier & Payan 2009.
//
// Eq. 3 is printed with "max", which would give every silent muscle its full capacity and contradicts the text and
// Table II; it is read as M = min[rho (exp(c A) - 1), rho]. The active force therefore saturates at the capacity rho
// at the activation ln 2 / c (17.3 mm for c = 40 / m).
// Eq. 5 (Laboissiere et al. 1996): F = M (f1 + f2 atan(f3 + f4 v) + f5 v), v = rate of length / rest length. The factor
// is 1.00004 at rest; it falls through zero near v = -3.5 / s and is held at zero beyond, since a fibre cannot push.
#pragma once

#include <cmath>

namespace glossa {

struct ForceLaw {
  double c = 40.0;             ///< 1/m, MN firing gradient (II.C.2)
  bool force_velocity = true;  ///< eq. 5 in force
  double f1 = 0.7109;          ///< eq. 5
  double f2 = 0.712;
  double f3 = 0.43;
  double f4 = 0.4444;  ///< s
  double f5 = 0.0329;  ///< s

  /// Activation (m) beyond which the force no longer grows.
  [[nodiscard]] double saturation_activation() const { return std::log(2.0) / c; }
  /// Active force over capacity, 0..1 (eq. 3).
  [[nodiscard]] double level(double activation) const {
    if (activation <= 0.0) return 0.0;
    return activation >= saturation_activation() ? 1.0 : std::expm1(c * activation);
  }
  /// d level / d activation, 1/m; zero at and beyond saturation and where silent.
  [[nodiscard]] double level_slope(double activation) const {
    if (activation <= 0.0 || activation >= saturation_activation()) return 0.0;
    return c * std::exp(c * activation);
  }
  /// Integral of level over activation, m.
  [[nodiscard]] double level_integral(double activation) const {
    if (activation <= 0.0) return 0.0;
    const double top = saturation_activation();
    if (activation >= top) return (1.0 / c - top) + (activation - top);
    return std::expm1(c * activation) / c - activation;
  }
  /// Factor of eq. 5 at the relative lengthening rate v (1/s), never negative; 1 when the effect is off.
  [[nodiscard]] double velocity_factor(double v) const {
    if (!force_velocity) return 1.0;
    return std::fmax(0.0, f1 + f2 * std::atan(f3 + f4 * v) + f5 * v);
  }
  /// d factor / d v, s; zero where the factor is held at zero.
  [[nodiscard]] double velocity_slope(double v) const {
    if (!force_velocity || velocity_factor(v) <= 0.0) return 0.0;
    const double x = f3 + f4 * v;
    return f2 * f4 / (1.0 + x * x) + f5;
  }
};

}  // namespace glossa

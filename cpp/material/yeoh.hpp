// Second-order Yeoh law of tongue tissue with a quadratic volumetric part.
//
//   W(F) = s [ c10 (I - 3) + c20 (I - 3)^2 ] + (kappa / 2) (J - 1)^2,   I = J^(-2/3) tr(F^T F)
//
// c10, c20: Buchaillard, Perrier & Payan 2009, II.B (1037 and 486 Pa; cadaver 192 and 90 Pa). s is the factor of eq. 1
// by which an activated muscle stiffens its tissue; it scales the isochoric part only, so that activation does not
// change the bulk modulus. kappa = 2 mu (1 + nu) / (3 (1 - 2 nu)), mu = 2 c10 (linear elasticity at small strain).
#pragma once

namespace glossa {

struct Yeoh {
  double c10;    ///< Pa, > 0
  double c20;    ///< Pa, >= 0
  double kappa;  ///< Pa, bulk modulus, > 0

  /// Isochoric energy density (Pa) of the modified first invariant `i1` (3 at rest).
  template <class Scalar>
  [[nodiscard]] Scalar isochoric(const Scalar& i1) const {
    const Scalar x = i1 - 3.0;
    return c10 * x + c20 * x * x;
  }
  /// dW/dI (Pa).
  template <class Scalar>
  [[nodiscard]] Scalar isochoric_slope(const Scalar& i1) const {
    return c10 + 2.0 * c20 * (i1 - 3.0);
  }
  /// d2W/dI2 (Pa), constant for this law.
  [[nodiscard]] double isochoric_curvature() const { return 2.0 * c20; }

  /// Volumetric energy density (Pa) of a volume ratio.
  template <class Scalar>
  [[nodiscard]] Scalar volumetric(const Scalar& volume_ratio) const {
    return 0.5 * kappa * (volume_ratio - 1.0) * (volume_ratio - 1.0);
  }
  /// Pressure dU/dJ (Pa, positive in dilatation).
  template <class Scalar>
  [[nodiscard]] Scalar pressure(const Scalar& volume_ratio) const {
    return kappa * (volume_ratio - 1.0);
  }
};

}  // namespace glossa

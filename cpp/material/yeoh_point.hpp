// Energy, stress and tangent of the Yeoh law at a single deformation gradient.
#pragma once

#include <Eigen/Core>

#include "material/yeoh.hpp"

namespace glossa {

/// Energy density, first Piola-Kirchhoff stress and its derivative at one deformation gradient.
/// The element kernels hold the same formulas contracted with the shape functions; this form serves single points.
struct YeohPoint {
  double energy;                        ///< Pa
  Eigen::Matrix3d stress;               ///< P = dW/dF, Pa
  Eigen::Matrix<double, 9, 9> tangent;  ///< dP/dF, Pa, both indices column-major (vec F)
};

/// Energy, stress and tangent of `law` at F (det F > 0) with the isochoric part scaled by `stiffening`.
[[nodiscard]] YeohPoint evaluate(const Yeoh& law, const Eigen::Matrix3d& F, double stiffening = 1.0);

}  // namespace glossa

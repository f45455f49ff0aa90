#include "material/yeoh_point.hpp"

#include <Eigen/LU>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace glossa {

YeohPoint evaluate(const Yeoh& law, const Eigen::Matrix3d& F, double stiffening) {
  const double J = F.determinant();
  require(J > 0.0, "deformation gradient: its determinant must be positive, it is " + std::to_string(J));
  const Eigen::Matrix3d H = F.inverse().transpose();
  const double a = 1.0 / std::cbrt(J * J);
  const double trace = F.squaredNorm();
  const double i1 = a * trace;
  const double slope = stiffening * law.isochoric_slope(i1);
  const double curvature = stiffening * law.isochoric_curvature();
  const double p = law.pressure(J);
  const Eigen::Matrix3d di = 2.0 * a * (F - trace / 3.0 * H);

  YeohPoint point;
  point.energy = stiffening * law.isochoric(i1) + law.volumetric(J);
  point.stress = slope * di + p * J * H;
  for (int l = 0; l < 3; ++l)
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) {
          const double identity = (i == k && j == l) ? 1.0 : 0.0;
          const double cross = H(i, l) * H(k, j);
          const double second = 2.0 * a *
                                (identity - 2.0 / 3.0 * (H(i, j) * F(k, l) + F(i, j) * H(k, l)) + trace / 3.0 * cross +
                                 2.0 * trace / 9.0 * H(i, j) * H(k, l));
          point.tangent(i + 3 * j, k + 3 * l) = slope * second + curvature * di(i, j) * di(k, l) +
                                                law.kappa * J * J * H(i, j) * H(k, l) +
                                                p * J * (H(i, j) * H(k, l) - cross);
        }
  return point;
}

}  // namespace glossa

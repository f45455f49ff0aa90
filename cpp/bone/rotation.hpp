// Rotations by their rotation vector theta (direction: axis, length: angle in rad).
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "core/types.hpp"

namespace glossa {

/// The matrix [v] with [v] x = v x x.
inline Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 result;
  result << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return result;
}

/// Coefficients of J = I + b [theta] + c [theta]^2 and their derivatives over the angle, divided by the angle.
struct RotationSeries {
  double b, c, b_slope, c_slope;

  explicit RotationSeries(double angle) {
    const double s = angle, s2 = s * s;
    if (s < 0.1) {  // Taylor series: the closed forms cancel
      b = 0.5 - s2 / 24.0 * (1.0 - s2 / 30.0 * (1.0 - s2 / 56.0));
      c = 1.0 / 6.0 - s2 / 120.0 * (1.0 - s2 / 42.0 * (1.0 - s2 / 72.0));
      b_slope = -1.0 / 12.0 + s2 / 180.0 * (1.0 - s2 * 3.0 / 112.0);
      c_slope = -1.0 / 60.0 + s2 / 1260.0 * (1.0 - s2 / 48.0);
    } else {
      b = (1.0 - std::cos(s)) / s2;
      c = (s - std::sin(s)) / (s2 * s);
      b_slope = (std::sin(s) / s2 - 2.0 * b / s) / s;
      c_slope = (b / s - 3.0 * c / s) / s;
    }
  }
};

/// Rotation matrix exp [theta] (Rodrigues).
inline Matrix3 rotation_matrix(const Vector3& theta) {
  const double angle = theta.norm();
  return angle == 0.0 ? Matrix3(Matrix3::Identity()) : Matrix3(Eigen::AngleAxisd(angle, theta / angle));
}

/// J of the rotation vector: exp [theta + d] = exp [J d] exp [theta] to first order in d ("left Jacobian" of SO(3)).
inline Matrix3 rotation_jacobian(const Vector3& theta) {
  const RotationSeries series(theta.norm());
  const Matrix3 cross = cross_matrix(theta);
  return Matrix3::Identity() + series.b * cross + series.c * cross * cross;
}

/// Derivative of J(theta)' m with respect to theta, m held.
inline Matrix3 pulled_moment_slope(const Vector3& theta, const Vector3& m) {
  const RotationSeries series(theta.norm());
  const Vector3 once = theta.cross(m), twice = theta.cross(once);
  return series.b * cross_matrix(m) - series.b_slope * once * theta.transpose() -
         series.c * (cross_matrix(once) + cross_matrix(theta) * cross_matrix(m)) +
         series.c_slope * twice * theta.transpose();
}

}  // namespace glossa

// Four points and a triangle at once, in single precision with a bound of the rounding.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "contact/simplex_shapes.hpp"

namespace glossa {

typedef float Four __attribute__((vector_size(16)));

inline Four four(float value) {
  return Four{value, value, value, value};
}
inline Four least(Four a, Four b) {
  return a < b ? a : b;
}
inline Four most(Four a, Four b) {
  return a > b ? a : b;
}

/// A triangle in its plane: first side along the first axis, corners (0, 0), (length, 0), (x, y), y > 0.
struct TriangleFrame {
  Vector3 origin, along, across, normal;
  double length, x, y;

  explicit TriangleFrame(const TriangleShape& shape)
      : origin(shape.a), along(shape.ab.normalized()), normal(shape.normal), length(shape.ab.norm()) {
    across = normal.cross(along);
    x = along.dot(shape.ac);
    y = across.dot(shape.ac);
  }
};

/// A triangle as seen from a centre: points are given relative to it.
struct LocalTriangle {
  float along[4], across[4], normal[4];  // axes and, last, the place of the centre on them
  float length, x, y, side_x, per_second, per_third;
  float rounding;  // of squared distances, m2
  Index number;

  /// For points within `reach` (m) of the centre.
  LocalTriangle(const TriangleFrame& frame, Index triangle, const Vector3& centre, double reach) : number(triangle) {
    const Vector3 offset = centre - frame.origin;
    const auto set = [&](const Vector3& axis, float* out) {
      for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(axis[k]);
      out[3] = static_cast<float>(axis.dot(offset));
    };
    set(frame.along, along);
    set(frame.across, across);
    set(frame.normal, normal);
    const double third = frame.x - frame.length, second = frame.x * frame.x + frame.y * frame.y;
    length = static_cast<float>(frame.length);
    x = static_cast<float>(frame.x);
    y = static_cast<float>(frame.y);
    side_x = static_cast<float>(third);
    per_second = static_cast<float>(1.0 / second);
    per_third = static_cast<float>(1.0 / (third * third + frame.y * frame.y));
    // Coordinates are off by a few epsilon of the size, squares by twice that times the size.
    constexpr double epsilon = std::numeric_limits<float>::epsilon();
    const double size = offset.norm() + reach + frame.length + std::sqrt(second);
    rounding = static_cast<float>(32.0 * epsilon * size * size);
  }

  /// Way from the nearest point of the triangle, along its axes.
  struct Way {
    Four along, across, normal;
    [[nodiscard]] Four squared() const { return along * along + across * across + normal * normal; }
  };
  [[nodiscard]] Way way(Four px, Four py, Four pz) const {
    const auto place = [&](const float* axis) { return axis[0] * px + axis[1] * py + axis[2] * pz + axis[3]; };
    const auto clamped = [](Four value, Four limit) { return least(most(value, Four{}), limit); };
    const Four u = place(along), v = place(across), w = u - length, one = four(1.0F);
    Four du = u - clamped(u, four(length)), dv = v, squared = du * du + dv * dv;
    const auto improve = [&](Four eu, Four ev) {
      const Four other = eu * eu + ev * ev;
      du = other < squared ? eu : du;
      dv = other < squared ? ev : dv;
      squared = least(other, squared);
    };
    const Four s = clamped((x * u + y * v) * per_second, one);
    improve(u - s * x, v - s * y);
    const Four t = clamped((side_x * w + y * v) * per_third, one);
    improve(w - t * side_x, v - t * y);
    const Four within = least(v, least(y * u - x * v, side_x * v - y * w));
    du = within >= Four{} ? Four{} : du;
    dv = within >= Four{} ? Four{} : dv;
    return {du, dv, place(normal)};
  }
  /// In the coordinates of the points.
  [[nodiscard]] Four component(const Way& way, int axis) const {
    return along[axis] * way.along + across[axis] * way.across + normal[axis] * way.normal;
  }
};

}  // namespace glossa

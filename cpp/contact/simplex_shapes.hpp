// A triangle and a straight piece, prepared for nearest points.
#pragma once

#include <algorithm>

#include "core/types.hpp"

namespace glossa {

/// Parts of a triangle: corners 0 1 2, sides 3 4 5 (3 + k joins corners k, k + 1), face 6.
struct TriangleShape {
  Vector3 a, ab, ac, normal;
  double abab, abac, acac;

  struct Point {
    double squared;  // distance squared, m2
    double v, w;     // the point is a + v ab + w ac
    int part;
  };
  [[nodiscard]] Point nearest(const Vector3& x) const;
  [[nodiscard]] double squared_distance(const Vector3& x) const { return nearest(x).squared; }
};

/// A straight piece a + s ab, 0 <= s <= 1.
struct SegmentShape {
  Vector3 a, ab;
  double abab;

  [[nodiscard]] double squared_distance(const Vector3& x) const {
    const Vector3 ax = x - a;
    return (ax - std::clamp(ab.dot(ax) / abab, 0.0, 1.0) * ab).squaredNorm();
  }
};

/// Ericson, Real-Time Collision Detection (2005), section 5.1.5.
inline TriangleShape::Point TriangleShape::nearest(const Vector3& x) const {
  const Vector3 ax = x - a;
  const auto at = [&](double v, double w, int part) -> Point {
    return {(ax - v * ab - w * ac).squaredNorm(), v, w, part};
  };
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0.0 && d2 <= 0.0) return at(0.0, 0.0, 0);
  const double d3 = d1 - abab, d4 = d2 - abac;
  if (d3 >= 0.0 && d4 <= d3) return at(1.0, 0.0, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return at(d1 / abab, 0.0, 3);
  const double d5 = d1 - abac, d6 = d2 - acac;
  if (d6 >= 0.0 && d5 <= d6) return at(0.0, 1.0, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return at(0.0, d2 / acac, 5);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return at(1.0 - w, w, 4);
  }
  const double height = normal.dot(ax), scale = 1.0 / (va + vb + vc);
  return {height * height, vb * scale, vc * scale, 6};
}

}  // namespace glossa

// A regular grid of points.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// Points origin + spacing (i, j, k); the last index runs fastest.
struct Lattice {
  Vector3 origin = Vector3::Zero();  // m
  double spacing = 0.0;              // m
  std::array<int, 3> size{0, 0, 0};

  [[nodiscard]] Vector3 point(double i, double j, double k) const { return origin + spacing * Vector3(i, j, k); }
};

}  // namespace glossa

// A regular grid of points.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// Points origin + spacing (i, j, k); the last index runs fastest.
struct Lattice {
  Vector3 origin = Vector3::Zero();  // m
  double spacing = 0.0;              // m
  std::array<int, 3> size{0, 0, 0};

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(i) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(k);
  }
  [[nodiscard]] Vector3 point(double i, double j, double k) const { return origin + spacing * Vector3(i, j, k); }
};

}  // namespace glossa

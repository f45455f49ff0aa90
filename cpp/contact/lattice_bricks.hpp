// A lattice cut into bricks of 4 x 4 x 4 points.
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/lattice.hpp"

namespace glossa {

struct Brick {
  std::array<int, 3> first, last;  // points first <= . < last

  template <class Visit>
  void each(Visit&& visit) const {
    for (int i = first[0]; i < last[0]; ++i)
      for (int j = first[1]; j < last[1]; ++j)
        for (int k = first[2]; k < last[2]; ++k) visit(i, j, k);
  }
};

class LatticeBricks {
 public:
  static constexpr int edge = 4;

  explicit LatticeBricks(const Lattice& lattice) : lattice_(lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) size_[axis] = (lattice.size[axis] + edge - 1) / edge;
  }
  [[nodiscard]] int count() const { return size_[0] * size_[1] * size_[2]; }
  [[nodiscard]] Brick operator[](int number) const {
    Brick brick{};
    const std::array<int, 3> place = place_of(number);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      brick.first[axis] = edge * place[axis];
      brick.last[axis] = std::min(edge * (place[axis] + 1), lattice_.size[axis]);
    }
    return brick;
  }
  [[nodiscard]] Vector3 centre(const Brick& b) const {
    return lattice_.point(0.5 * (b.first[0] + b.last[0] - 1), 0.5 * (b.first[1] + b.last[1] - 1),
                          0.5 * (b.first[2] + b.last[2] - 1));
  }
  /// Whether the brick lies at a face of the lattice.
  [[nodiscard]] bool at_face(int number) const {
    const std::array<int, 3> place = place_of(number);
    bool face = false;
    for (std::size_t axis = 0; axis < 3; ++axis) face = face || place[axis] == 0 || place[axis] == size_[axis] - 1;
    return face;
  }
  /// visit(number) for the bricks that meet the box from low to high (m); beyond the lattice the nearest ones.
  template <class Visit>
  void within(const Vector3& low, const Vector3& high, Visit&& visit) const {
    std::array<int, 3> first{}, last{};
    for (int axis = 0; axis < 3; ++axis) {
      const double step = edge * lattice_.spacing, most = size_[static_cast<std::size_t>(axis)] - 1.0;
      const auto place = [&](double x) {
        return static_cast<int>(std::clamp(std::floor((x - lattice_.origin[axis]) / step), 0.0, most));
      };
      first[static_cast<std::size_t>(axis)] = place(low[axis]);
      last[static_cast<std::size_t>(axis)] = place(high[axis]);
    }
    visit_range(first, last, visit);
  }
  /// visit(number) for a brick and those that touch it.
  template <class Visit>
  void around(int number, Visit&& visit) const {
    std::array<int, 3> first = place_of(number), last = first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(first[axis] - 1, 0);
      last[axis] = std::min(last[axis] + 1, size_[axis] - 1);
    }
    visit_range(first, last, visit);
  }
  /// Distance from the centre to a corner point, m.
  [[nodiscard]] double radius(const Brick& b) const {
    return 0.5 * lattice_.spacing *
           Vector3(b.last[0] - b.first[0] - 1, b.last[1] - b.first[1] - 1, b.last[2] - b.first[2] - 1).norm();
  }

 private:
  [[nodiscard]] std::array<int, 3> place_of(int number) const {
    return {number / (size_[1] * size_[2]), number / size_[2] % size_[1], number % size_[2]};
  }
  template <class Visit>
  void visit_range(const std::array<int, 3>& first, const std::array<int, 3>& last, Visit&& visit) const {
    for (int i = first[0]; i <= last[0]; ++i)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int k = first[2]; k <= last[2]; ++k) visit((i * size_[1] + j) * size_[2] + k);
  }

  const Lattice& lattice_;
  std::array<int, 3> size_{};
};

}  // namespace glossa

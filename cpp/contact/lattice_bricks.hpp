// A lattice cut into bricks of 4 x 4 x 4 points, and values kept only in bricks where they vary.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/lattice.hpp"

namespace glossa {

/// Bricks are numbered with the last index fastest, and so are the points of a brick. The last bricks may reach beyond
/// the lattice.
class LatticeBricks {
 public:
  static constexpr int edge = 4;
  static constexpr std::size_t volume = 64;
  using Place = std::array<int, 3>;  // of a brick among bricks, or of a point among points

  LatticeBricks() = default;
  explicit LatticeBricks(const Lattice& lattice) : lattice_(lattice) {
    for (std::size_t axis = 0; axis < 3; ++axis) size_[axis] = (lattice.size[axis] + edge - 1) / edge;
  }
  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  [[nodiscard]] const Place& size() const { return size_; }
  [[nodiscard]] int count() const { return size_[0] * size_[1] * size_[2]; }
  [[nodiscard]] Place place_of(int number) const {
    return {number / (size_[1] * size_[2]), number / size_[2] % size_[1], number % size_[2]};
  }
  [[nodiscard]] int number_of(int i, int j, int k) const { return (i * size_[1] + j) * size_[2] + k; }
  /// Of a point in its brick.
  static std::size_t offset_of(int i, int j, int k) {
    return static_cast<std::size_t>(((i & (edge - 1)) * edge + (j & (edge - 1))) * edge + (k & (edge - 1)));
  }
  /// Where a point of the brick is, m.
  [[nodiscard]] Vector3 point(int number, double i, double j, double k) const {
    const Place place = place_of(number);
    return lattice_.point(edge * place[0] + i, edge * place[1] + j, edge * place[2] + k);
  }
  [[nodiscard]] Vector3 centre(int number) const {
    constexpr double middle = 0.5 * (edge - 1);
    return point(number, middle, middle, middle);
  }
  /// Distance from the centre to a corner point, m.
  [[nodiscard]] double radius() const { return 0.5 * (edge - 1) * std::sqrt(3.0) * lattice_.spacing; }

  /// Whether the brick lies at a face of the lattice.
  [[nodiscard]] bool at_face(int number) const {
    const Place place = place_of(number);
    bool face = false;
    for (std::size_t axis = 0; axis < 3; ++axis) face = face || place[axis] == 0 || place[axis] == size_[axis] - 1;
    return face;
  }
  /// visit(number) for the bricks that meet the box from low to high (m); beyond the lattice the nearest ones.
  template <class Visit>
  void within(const Vector3& low, const Vector3& high, Visit&& visit) const {
    Place first{}, last{};
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
    Place first = place_of(number), last = first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = std::max(first[axis] - 1, 0);
      last[axis] = std::min(last[axis] + 1, size_[axis] - 1);
    }
    visit_range(first, last, visit);
  }
  /// A brick and the 26 around it, the last index fastest; beyond the lattice the nearest ones.
  [[nodiscard]] std::array<int, 27> cube_around(int number) const {
    const Place place = place_of(number);
    const auto clamped = [&](std::size_t axis, int step) { return std::clamp(place[axis] + step, 0, size_[axis] - 1); };
    std::array<int, 27> result;
    for (int n = 0; n < 27; ++n)
      result[static_cast<std::size_t>(n)] =
          number_of(clamped(0, n / 9 - 1), clamped(1, n / 3 % 3 - 1), clamped(2, n % 3 - 1));
    return result;
  }

 private:
  template <class Visit>
  void visit_range(const Place& first, const Place& last, Visit&& visit) const {
    for (int i = first[0]; i <= last[0]; ++i)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int k = first[2]; k <= last[2]; ++k) visit(number_of(i, j, k));
  }

  Lattice lattice_;
  Place size_{};
};

/// Values in blocks of one brick each. The first blocks are uniform and shared by all bricks that are so throughout.
template <class Value>
struct BrickValues {
  static constexpr std::size_t volume = LatticeBricks::volume;
  using Halo = std::array<Value, 216>;  // of a brick and the points around it, 6 x 6 x 6

  std::vector<Value> values;
  Index shared = 0;  // number of uniform blocks

  BrickValues() = default;
  explicit BrickValues(const std::vector<Value>& uniform) : shared(static_cast<Index>(uniform.size())) {
    for (const Value& value : uniform) values.insert(values.end(), volume, value);
  }
  [[nodiscard]] Value* block(Index number) { return values.data() + volume * static_cast<std::size_t>(number); }
  [[nodiscard]] const Value* block(Index number) const {
    return values.data() + volume * static_cast<std::size_t>(number);
  }
  /// A block of its own that starts as a copy; its number.
  Index copy(Index number) {
    const std::size_t size = values.size();
    values.resize(size + volume);
    std::copy_n(block(number), volume, values.data() + size);
    return static_cast<Index>(size / volume);
  }
  /// Points beyond the bricks repeat the last ones.
  void halo(const LatticeBricks& bricks, const std::vector<Index>& block_of, int number, Halo& halo) const {
    const auto place = bricks.place_of(number);
    const auto& size = bricks.size();
    const std::array<int, 27> around = bricks.cube_around(number);
    const Value* near[27];
    for (std::size_t n = 0; n < 27; ++n) near[n] = block(block_of[static_cast<std::size_t>(around[n])]);
    // Brick before, in or after, and the point there, for places -1 to 4 along an axis.
    const auto split = [&](std::size_t axis, int t) -> std::pair<int, int> {
      if (t < 0) return {0, place[axis] == 0 ? 0 : 3};
      if (t > 3) return {2, place[axis] == size[axis] - 1 ? 3 : 0};
      return {1, t};
    };
    const int first = split(2, -1).second, last = split(2, 4).second;
    Value* out = halo.data();
    for (int i = -1; i <= 4; ++i)
      for (int j = -1; j <= 4; ++j, out += 6) {
        const auto [brick_i, point_i] = split(0, i);
        const auto [brick_j, point_j] = split(1, j);
        const int row = 16 * point_i + 4 * point_j;
        const Value* const* line = near + 9 * brick_i + 3 * brick_j;
        out[0] = line[0][row + first];
        for (int k = 0; k < 4; ++k) out[k + 1] = line[1][row + k];
        out[5] = line[2][row + last];
      }
  }
};

}  // namespace glossa

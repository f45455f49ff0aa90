// Which of many shapes can be nearest to the points of a ball: found once, then asked for each point.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/box_tree.hpp"

namespace glossa {

template <class Shape>
class Candidates {
 public:
  explicit Candidates(const std::vector<Shape>& shapes) : shapes_(shapes) {}

  void clear() { list_.clear(); }
  [[nodiscard]] bool empty() const { return list_.empty(); }

  /// Those for the ball (m), whose centre is `nearest` (m) from the nearest shape. `tree` is over all shapes.
  void gather(const BoxTree& tree, const Vector3& centre, double radius, double nearest) {
    list_.clear();
    centre_ = centre;
    const double bound = rounded_up(nearest + 2.0 * radius);
    tree.within(centre, bound, [&](Index item) {
      const double distance = std::sqrt(shape(item).squared_distance(centre));
      if (distance <= bound) list_.push_back({distance, item});
    });
    std::sort(list_.begin(), list_.end());
  }

  /// The shape nearest to a point of the ball and its distance squared; ties go to the lowest number.
  [[nodiscard]] BoxTree::Found nearest(const Vector3& x) const {
    const double offset = (x - centre_).norm();
    BoxTree::Found best{-1, std::numeric_limits<double>::infinity()};
    double bound = best.squared;
    for (const auto& [from_centre, item] : list_) {
      if (from_centre > bound) break;
      const double squared = shape(item).squared_distance(x);
      if (squared > best.squared || (squared == best.squared && item > best.item)) continue;
      best = {item, squared};
      bound = rounded_up(std::sqrt(squared) + offset);
    }
    return best;
  }

 private:
  [[nodiscard]] const Shape& shape(Index item) const { return shapes_[static_cast<std::size_t>(item)]; }
  static double rounded_up(double length) { return length * (1.0 + 1e-12); }

  const std::vector<Shape>& shapes_;
  Vector3 centre_ = Vector3::Zero();
  std::vector<std::pair<double, Index>> list_;  // by distance from the centre
};

}  // namespace glossa

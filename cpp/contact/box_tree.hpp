// A tree of axis-parallel boxes: the nearest of many items, or those near a point.
#pragma once

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/types.hpp"

namespace glossa {

/// An axis-parallel box, m; empty until something is added.
struct Box {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 high = Vector3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vector3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  void add(const Box& box) {
    low = low.cwiseMin(box.low);
    high = high.cwiseMax(box.high);
  }
  [[nodiscard]] double squared_distance(const Vector3& x) const {
    return (low - x).cwiseMax(x - high).cwiseMax(0.0).squaredNorm();
  }
};

/// Items are numbers; the caller measures them. Ties go to the lowest number, so that results do not depend on the
/// order of the search.
class BoxTree {
 public:
  struct Found {
    Index item = -1;  // -1: none within the bound
    double squared = 0.0;
  };

  BoxTree() = default;
  explicit BoxTree(const std::vector<Box>& boxes) {
    items_.resize(boxes.size());
    std::iota(items_.begin(), items_.end(), 0);
    if (!boxes.empty()) build(boxes, 0, static_cast<Index>(boxes.size()));
  }

  /// The item of least measure(item), a squared distance from x not below that of the item's box, up to `bound`.
  template <class Measure>
  [[nodiscard]] Found nearest(const Vector3& x, Measure&& measure,
                              double bound = std::numeric_limits<double>::infinity()) const {
    Found best{-1, bound};
    descend(
        x, [&] { return best.squared; },
        [&](Index item) {
          const double squared = measure(item);
          if (squared < best.squared || (squared == best.squared && (best.item < 0 || item < best.item)))
            best = {item, squared};
        });
    return best;
  }

  /// visit(item) for every item whose box is within `radius` of x.
  template <class Visit>
  void within(const Vector3& x, double radius, Visit&& visit) const {
    where([&](const Box& box) { return box.squared_distance(x) <= radius * radius; }, visit);
  }

  /// visit(item) for every item in boxes for which keep(box); a box is not kept unless all that hold it are.
  template <class Keep, class Visit>
  void where(Keep&& keep, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<Index, deepest> stack;
    std::size_t height = 0;
    stack[height++] = 0;
    while (height > 0) {
      const Index number = stack[--height];
      const Node& node = nodes_[static_cast<std::size_t>(number)];
      if (!keep(node.box)) continue;
      if (node.right == 0) {
        for (Index k = node.begin; k < node.end; ++k) visit(items_[static_cast<std::size_t>(k)]);
        continue;
      }
      stack[height++] = node.right;
      stack[height++] = number + 1;
    }
  }

 private:
  struct Node {
    Box box;
    Index begin, end;  // its items
    Index right;       // second child; the first is the next node; 0 for a leaf
  };
  static constexpr Index leaf_size = 4;
  static constexpr int deepest = 64;

  Index build(const std::vector<Box>& boxes, Index begin, Index end) {
    const auto number = nodes_.size();
    nodes_.push_back({{}, begin, end, 0});
    Box box, centres;
    const auto centre = [&](Index item) -> Vector3 {
      const Box& b = boxes[static_cast<std::size_t>(item)];
      return 0.5 * (b.low + b.high);
    };
    for (auto item = items_.begin() + begin; item != items_.begin() + end; ++item) {
      box.add(boxes[static_cast<std::size_t>(*item)]);
      centres.add(centre(*item));
    }
    nodes_[number].box = box;
    if (end - begin > leaf_size) {
      Eigen::Index axis = 0;
      (centres.high - centres.low).maxCoeff(&axis);
      const Index middle = begin + (end - begin) / 2;
      std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end, [&](Index p, Index q) {
        const double a = centre(p)[axis], b = centre(q)[axis];
        return a < b || (a == b && p < q);
      });
      build(boxes, begin, middle);
      nodes_[number].right = build(boxes, middle, end);
    }
    return static_cast<Index>(number);
  }

  template <class Bound, class Visit>
  void descend(const Vector3& x, Bound&& bound, Visit&& visit) const {
    if (nodes_.empty()) return;
    struct Entry {
      Index node;
      double squared;
    };
    std::array<Entry, deepest> stack;
    std::size_t height = 0;
    stack[height++] = {0, nodes_[0].box.squared_distance(x)};
    while (height > 0) {
      const Entry entry = stack[--height];
      if (entry.squared > bound()) continue;
      const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
      if (node.right == 0) {
        for (Index k = node.begin; k < node.end; ++k) visit(items_[static_cast<std::size_t>(k)]);
        continue;
      }
      Entry near{entry.node + 1, nodes_[static_cast<std::size_t>(entry.node) + 1].box.squared_distance(x)};
      Entry far{node.right, nodes_[static_cast<std::size_t>(node.right)].box.squared_distance(x)};
      if (far.squared < near.squared) std::swap(near, far);
      stack[height++] = far;
      stack[height++] = near;
    }
  }

  std::vector<Index> items_;
  std::vector<Node> nodes_;
};

}  // namespace glossa

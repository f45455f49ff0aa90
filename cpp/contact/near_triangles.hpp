// The triangles nearest to the points of a brick: those that can be nearest are found once for the brick, then narrowed
// for its eight corners of eight points each.
//
// The distance from a triangle is a convex function. So from a centre c, with g its gradient there, a triangle is no
// nearer to p than d(c) + g . (p - c); and the distance from another triangle less that bound, being convex, is largest
// at a corner of the box of points. A triangle whose bound exceeds that distance at all corners is nowhere the nearest.
// For a box that holds triangles the same is true. What is left is told apart in single precision with a bound of its
// error, and where that leaves several they are measured exactly: the result is the nearest triangle, of equals the one
// with the lowest number.
#pragma once

#include <array>
#include <cstring>

#include "contact/nearest_feature.hpp"
#include "contact/triangle_lanes.hpp"

namespace glossa {

class NearTriangles {
 public:
  static constexpr std::size_t corners = 8;
  using Points = std::array<Vector3, corners>;

  /// Frames of all triangles of the wall, in order.
  NearTriangles(const NearestFeature& wall, const std::vector<TriangleFrame>& frames) : wall_(wall), frames_(frames) {}

  /// Those for a cube of points around a centre. `side`: half its edge, m. `nearest`: the triangle nearest to the
  /// centre.
  void gather(const Vector3& centre, double side, Index nearest) {
    centre_ = centre;
    list_.clear();
    const CornerBound bound(wall_.shape(nearest), centre, side);
    const double reach = 2.0 * side;
    wall_.tree().where(
        [&](const Box& box) { return bound.admits(centre - centre.cwiseMax(box.low).cwiseMin(box.high)); },
        [&](Index item) {
          const TriangleShape& shape = wall_.shape(item);
          const TriangleShape::Point q = shape.nearest(centre);
          if (bound.admits(centre - (shape.a + q.v * shape.ab + q.w * shape.ac)))
            list_.emplace_back(frames_[static_cast<std::size_t>(item)], item, centre, reach);
        });
  }

  struct Found {
    Index triangle = -1;
    TriangleShape::Point point{std::numeric_limits<double>::infinity(), 0.0, 0.0, 0};
  };
  using Results = std::array<std::array<Found, corners>, corners>;

  /// The nearest to the points of eight small cubes within the one gathered for: `points` by cube, their centres, half
  /// their edge (m). Points of a cube are in the order of the bits of their number, z fastest.
  void nearest(const std::array<Points, corners>& points, const Points& centres, double side, Results& results) {
    measure_ways(centres);
    for (std::size_t c = 0; c < corners; ++c) {
      const Index triangle = list_[first_[c]].number;
      for (std::size_t p = 0; p < corners; ++p) {
        results[c][p] = {triangle, wall_.shape(triangle).nearest(points[c][p])};
        upper_[p][c / 4][c % 4] = static_cast<float>((1.0 + 1e-5) * std::sqrt(results[c][p].point.squared));
      }
    }
    for (std::size_t n = 0; n < list_.size(); ++n) admitted_[n] = admits(n, static_cast<float>(side));
    for (std::size_t c = 0; c < corners; ++c) look_at(c, points[c], results[c]);
  }

 private:
  /// From one triangle's distance at the corners of a cube: which others can be nearer somewhere in it.
  class CornerBound {
   public:
    CornerBound(const TriangleShape& shape, const Vector3& centre, double side) : side_(side) {
      for (int k = 0; k < 4; ++k) {
        const Vector3 corner(k & 2 ? side : -side, k & 1 ? side : -side, side);
        before_[k] = std::sqrt(shape.squared_distance(centre + Vector3(corner.x(), corner.y(), -side)));
        after_[k] = std::sqrt(shape.squared_distance(centre + corner));
      }
      before_ *= 1.0 + slack;
      after_ *= 1.0 + slack;
      const double most = std::max(before_.maxCoeff(), after_.maxCoeff()) + 2.0 * side;
      farthest_ = most * most;  // the way from the centre to a corner is shorter than two sides
      nearest_ = shape.squared_distance(centre) + slack * slack;
    }
    /// `away`: the centre less the nearest point of the other.
    [[nodiscard]] bool admits(const Vector3& away) const {
      const double squared = away.squaredNorm();
      if (squared <= nearest_) return true;
      if (squared > farthest_) return false;
      const double distance = std::sqrt(squared);
      const double x = side_ * away.x(), y = side_ * away.y(), z = side_ * away.z();
      const Corners across(x + y, x - y, y - x, -x - y);
      const Corners best = (before_ * distance + z).max(after_ * distance - z) + across;
      return best.maxCoeff() >= squared * (1.0 - slack) - slack * slack;
    }

   private:
    using Corners = Eigen::Array4d;
    static constexpr double slack = 1e-9;  // relative; m
    double side_, farthest_, nearest_;
    Corners before_, after_;  // distances at the corners of low and high z
  };

  using Lanes = std::array<Four, 2>;  // eight numbers
  struct Ways {
    Lanes x, y, z, squared;
  };

  [[nodiscard]] std::array<Lanes, 3> relative(const Points& points) const {
    std::array<Lanes, 3> result;
    for (std::size_t p = 0; p < corners; ++p) {
      const Vector3 from = points[p] - centre_;
      for (std::size_t axis = 0; axis < 3; ++axis)
        result[axis][p / 4][p % 4] = static_cast<float>(from[static_cast<Eigen::Index>(axis)]);
    }
    return result;
  }

  /// Ways from all triangles of the list to eight centres; which of them is nearest to each.
  void measure_ways(const Points& centres) {
    const auto [x, y, z] = relative(centres);
    ways_.resize(list_.size());
    admitted_.resize(list_.size());
    std::array<float, corners> closest;
    closest.fill(std::numeric_limits<float>::infinity());
    for (std::size_t n = 0; n < list_.size(); ++n) {
      Ways& ways = ways_[n];
      for (std::size_t half = 0; half < 2; ++half) {
        const LocalTriangle::Way way = list_[n].way(x[half], y[half], z[half]);
        ways.x[half] = list_[n].component(way, 0);
        ways.y[half] = list_[n].component(way, 1);
        ways.z[half] = list_[n].component(way, 2);
        ways.squared[half] = way.squared();
      }
      for (std::size_t c = 0; c < corners; ++c)
        if (const float squared = ways.squared[c / 4][c % 4]; squared < closest[c]) {
          closest[c] = squared;
          first_[c] = n;
        }
    }
  }

  /// CornerBound for the eight cubes at once: by bits, in which of them triangle n of the list may be nearest.
  [[nodiscard]] unsigned admits(std::size_t n, float side) const {
    const Ways& ways = ways_[n];
    unsigned bits = 0;
    for (std::size_t half = 0; half < 2; ++half) {
      const Four squared = ways.squared[half];
      Four distance;
      for (int lane = 0; lane < 4; ++lane) distance[lane] = std::sqrt(squared[lane]);
      const Four x = side * ways.x[half], y = side * ways.y[half], z = side * ways.z[half];
      const Four sum = x + y, difference = x - y;
      const std::array<Four, 4> across{sum, difference, -difference, -sum};
      Four best = four(-std::numeric_limits<float>::infinity());
      for (std::size_t k = 0; k < 4; ++k) {
        best = most(best, upper_[2 * k][half] * distance + across[k] + z);
        best = most(best, upper_[2 * k + 1][half] * distance + across[k] - z);
      }
      const auto admitted = best >= squared - 2.0F * list_[n].rounding;
      for (int lane = 0; lane < 4; ++lane)
        bits |= static_cast<unsigned>(admitted[lane] != 0) << (4 * static_cast<int>(half) + lane);
    }
    return bits;
  }

  /// Improves the results at the points of cube c by the other triangles admitted there.
  void look_at(std::size_t c, const Points& points, std::array<Found, corners>& results) {
    const auto [x, y, z] = relative(points);
    for (std::size_t n = 0; n < list_.size(); ++n) {
      if ((admitted_[n] >> c & 1U) == 0 || n == first_[c]) continue;
      const LocalTriangle& triangle = list_[n];
      for (std::size_t half = 0; half < 2; ++half) {
        const Four low = triangle.way(x[half], y[half], z[half]).squared() - triangle.rounding;
        for (std::size_t lane = 0; lane < 4; ++lane)
          if (static_cast<double>(low[lane]) <= results[4 * half + lane].point.squared)
            improve(triangle.number, points[4 * half + lane], results[4 * half + lane]);
      }
    }
  }

  void improve(Index triangle, const Vector3& x, Found& best) const {
    const TriangleShape::Point point = wall_.shape(triangle).nearest(x);
    if (point.squared < best.point.squared || (point.squared == best.point.squared && triangle < best.triangle))
      best = {triangle, point};
  }

  const NearestFeature& wall_;
  const std::vector<TriangleFrame>& frames_;
  Vector3 centre_ = Vector3::Zero();
  std::vector<LocalTriangle> list_;
  std::vector<Ways> ways_;
  std::vector<unsigned> admitted_;
  std::array<std::size_t, corners> first_{};  // of the list, nearest to each small cube's centre
  std::array<Lanes, corners> upper_;          // distances from those at the points, by point
};

}  // namespace glossa

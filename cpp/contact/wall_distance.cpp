#include "contact/wall_distance.hpp"

#include <algorithm>
#include <cmath>

#include "contact/candidates.hpp"
#include "contact/near_triangles.hpp"
#include "contact/sheet_ends.hpp"
#include "core/parallel.hpp"

namespace glossa {
namespace {

constexpr std::size_t volume = LatticeBricks::volume;
constexpr std::size_t at_once = 2000;  // bricks, whose values fit a cache
constexpr double slack = 1e-9;         // relative; m

/// Up to where distances of brick centres are told: so far that clipping does not show between those of bricks within
/// reach of the wall.
double coarse_reach(const LatticeBricks& bricks, double reach) {
  return reach + 3.0 * LatticeBricks::edge * bricks.lattice().spacing;
}

/// What a brick is found to be.
struct BrickKind {
  bool near = false;      // within reach of the wall
  bool behind = false;    // the centre, or a point of a brick that is near, lies behind the wall
  bool limited = false;   // a point lies behind the wall and nearer to a curtain
  double distance = 0.0;  // of the centre, m
  Side side = Side::free;
};

/// Samples single bricks.
class Sampler {
 public:
  Sampler(const NearestFeature& wall, const std::vector<TriangleFrame>& frames, const LatticeBricks& bricks,
          double reach)
      : wall_(wall),
        bricks_(bricks),
        reach_(reach),
        radius_(bricks.radius()),
        triangles_(wall, frames),
        ends_(wall.ends()) {}

  /// Values are given to bricks that are near.
  BrickKind sample(int number, double* distance, Side* side) {
    kind_ = {};
    centre_ = bricks_.centre(number);
    ends_.clear();
    end_ = wall_.ends().empty() ? std::numeric_limits<double>::infinity() : -1.0;
    // The last one bounds the search; widened, so that rounding does not leave the box of the nearest out.
    const double bound = wall_.shape(last_).squared_distance(centre_);
    last_ = wall_.nearest_triangle(centre_, (1.0 + slack) * bound + slack * slack).item;
    const TriangleShape::Point nearest = wall_.shape(last_).nearest(centre_);
    kind_.side = side_of(centre_, last_, nearest);
    kind_.distance = signed_distance(centre_, nearest.squared, kind_.side, coarse_reach(bricks_, reach_));
    kind_.near = std::sqrt(nearest.squared) <= reach_ + radius_;
    if (!kind_.near) return kind_;
    find_nearest(number);
    for (std::size_t c = 0; c < 8; ++c)
      for (std::size_t p = 0; p < 8; ++p) {
        const auto& [triangle, q] = results_[c][p];
        const Vector3& x = points_[c][p];
        const std::size_t place = place_of(static_cast<int>(c), static_cast<int>(p));
        side[place] = side_of(x, triangle, q);
        distance[place] = signed_distance(x, q.squared, side[place], reach_);
      }
    return kind_;
  }

 private:
  /// Coordinate 0 or 1 of corner c of a cube.
  static int corner(int c, int axis) { return c >> (2 - axis) & 1; }
  /// Of point p of the eight at corner c of a brick.
  static std::size_t place_of(int c, int p) {
    return LatticeBricks::offset_of(2 * corner(c, 0) + corner(p, 0), 2 * corner(c, 1) + corner(p, 1),
                                    2 * corner(c, 2) + corner(p, 2));
  }

  void find_nearest(int number) {
    NearTriangles::Points centres;
    for (int c = 0; c < 8; ++c) {
      const int i = 2 * corner(c, 0), j = 2 * corner(c, 1), k = 2 * corner(c, 2);
      centres[static_cast<std::size_t>(c)] = bricks_.point(number, i + 0.5, j + 0.5, k + 0.5);
      for (int p = 0; p < 8; ++p)
        points_[static_cast<std::size_t>(c)][static_cast<std::size_t>(p)] =
            bricks_.point(number, i + corner(p, 0), j + corner(p, 1), k + corner(p, 2));
    }
    const double spacing = bricks_.lattice().spacing;
    triangles_.gather(centre_, 1.5 * spacing, last_);
    triangles_.nearest(points_, centres, 0.5 * spacing, results_);
  }

  [[nodiscard]] Side side_of(const Vector3& x, Index triangle, const TriangleShape::Point& q) const {
    if (wall_.kind(triangle, q.part) != FeatureKind::interior) return Side::free;
    return wall_.behind(x, triangle, q) ? Side::behind : Side::front;
  }

  double signed_distance(const Vector3& x, double squared, Side side, double reach) {
    const double distance = std::min(std::sqrt(squared), reach);
    if (side != Side::behind) return distance;
    kind_.behind = true;
    // The distance to the curtain, sqrt(e^2 - d^2), counts where it is less.
    const double least = std::sqrt(squared + distance * distance);
    if (end_distance() - (x - centre_).norm() >= least) return -distance;
    const double curtain = std::sqrt(std::max(squared_end_distance(x) - squared, 0.0));
    if (curtain >= distance) return -distance;
    kind_.limited = true;
    return -curtain;
  }

  /// Of the brick's centre.
  double end_distance() {
    if (end_ < 0.0) end_ = std::sqrt(wall_.nearest_end(centre_).squared);
    return end_;
  }

  /// e^2 at a point of the brick.
  double squared_end_distance(const Vector3& x) {
    if (ends_.empty()) ends_.gather(wall_.end_tree(), centre_, radius_, end_distance());
    return ends_.nearest(x).squared;
  }

  const NearestFeature& wall_;
  const LatticeBricks& bricks_;
  double reach_, radius_;
  NearTriangles triangles_;
  std::array<NearTriangles::Points, 8> points_;  // of the brick, by its corners
  NearTriangles::Results results_;
  Candidates<SegmentShape> ends_;
  Vector3 centre_ = Vector3::Zero();
  double end_ = -1.0;  // distance of the centre from the ends, once asked for
  Index last_ = 0;     // nearest triangle of the centre before
  BrickKind kind_;
};

/// Bricks where behind can begin: within `reach` of a triangle; and, as the wall may go on outside the lattice, those
/// at the lattice's faces.
std::vector<bool> first_bricks(const NearestFeature& wall, const LatticeBricks& bricks, double reach) {
  std::vector<bool> chosen(static_cast<std::size_t>(bricks.count()), false);
  for (const TriangleShape& shape : wall.shapes()) {
    Box box;
    for (const Vector3& corner : {shape.a, Vector3(shape.a + shape.ab), Vector3(shape.a + shape.ac)}) box.add(corner);
    bricks.within(box.low - Vector3::Constant(reach), box.high + Vector3::Constant(reach),
                  [&](int number) { chosen[static_cast<std::size_t>(number)] = true; });
  }
  for (int number = 0; number < bricks.count(); ++number)
    if (bricks.at_face(number)) chosen[static_cast<std::size_t>(number)] = true;
  return chosen;
}

/// Samples of several bricks, in blocks one after the other.
class Wave {
 public:
  explicit Wave(std::vector<int> numbers)
      : numbers_(std::move(numbers)),
        kinds_(numbers_.size()),
        distance_(volume * numbers_.size()),
        side_(volume * numbers_.size()) {}

  [[nodiscard]] const std::vector<int>& numbers() const { return numbers_; }
  [[nodiscard]] const BrickKind& kind(std::size_t k) const { return kinds_[k]; }

  void sample(Sampler& sampler, int begin, int end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k)
      kinds_[k] = sampler.sample(numbers_[k], distance_.data() + volume * k, side_.data() + volume * k);
  }
  /// Near bricks into `fine`, centres of all into `coarse`.
  void store(DistanceSamples& fine, DistanceSamples& coarse) const {
    for (std::size_t k = 0; k < numbers_.size(); ++k) {
      const int number = numbers_[k];
      if (kinds_[k].side != Side::free) {
        const auto place = fine.bricks.place_of(number);
        coarse.own(coarse.brick_of(place));
        const std::size_t entry = coarse.entry_of(place);
        coarse.distance.values[entry] = kinds_[k].distance;
        coarse.side.values[entry] = kinds_[k].side;
        if (kinds_[k].limited) coarse.limited.push_back(coarse.brick_of(place));
      }
      if (!kinds_[k].near) continue;
      if (kinds_[k].limited) fine.limited.push_back(number);
      const Index block = fine.own(number);
      std::copy_n(distance_.data() + volume * k, volume, fine.distance.block(block));
      std::copy_n(side_.data() + volume * k, volume, fine.side.block(block));
    }
  }

 private:
  std::vector<int> numbers_;
  std::vector<BrickKind> kinds_;
  std::vector<double> distance_;
  std::vector<Side> side_;
};

/// One point for each brick, at its centre.
Lattice centres(const LatticeBricks& bricks) {
  return {bricks.centre(0), LatticeBricks::edge * bricks.lattice().spacing, bricks.size()};
}

/// Fills a brick from the values at the centres of the 27 bricks around, linearly in each direction.
void interpolate(const std::array<double, 27>& centre, double reach, double* distance, Side* side) {
  constexpr std::array<double, 4> share{0.375, 0.125, 0.125, 0.375};  // of the neighbour, before or after
  for (std::size_t point = 0; point < volume; ++point) {
    const std::size_t i = point / 16, j = point / 4 % 4, k = point % 4;
    const std::size_t to_i = i < 2 ? 0 : 18, to_j = j < 2 ? 0 : 6, to_k = k < 2 ? 0 : 2;
    const auto line = [&](std::size_t from) {
      return (1.0 - share[k]) * centre[from + 1] + share[k] * centre[from + to_k];
    };
    const auto plane = [&](std::size_t from) {
      return (1.0 - share[j]) * line(from + 3) + share[j] * line(from + to_j);
    };
    distance[point] = std::clamp((1.0 - share[i]) * plane(9) + share[i] * plane(to_i), -reach, reach);
    side[point] = distance[point] < 0.0 ? Side::behind : Side::beside;
  }
}

/// Gives values to the bricks that are not near, `near[number]` being 0, from their centres: where some centre around
/// is behind or was lowered to the distance from a curtain. The others stay free.
void fill_far(const DistanceSamples& coarse, double reach, const std::vector<std::uint8_t>& near,
              DistanceSamples& fine) {
  const LatticeBricks& bricks = fine.bricks;
  std::vector<double> centre(near.size());
  std::vector<std::uint8_t> wanted(near.size());
  for (std::size_t n = 0; n < near.size(); ++n) {
    const std::size_t entry = coarse.entry_of(bricks.place_of(static_cast<int>(n)));
    centre[n] = coarse.distance.values[entry];
    if (coarse.side.values[entry] == Side::behind || (near[n] == 0 && centre[n] < reach))
      bricks.around(static_cast<int>(n), [&](int other) { wanted[static_cast<std::size_t>(other)] = 1; });
  }
  for (std::size_t n = 0; n < near.size(); ++n) {
    if (near[n] != 0 || wanted[n] == 0) continue;
    const int number = static_cast<int>(n);
    const std::array<int, 27> cube = bricks.cube_around(number);
    std::array<double, 27> around;
    std::transform(cube.begin(), cube.end(), around.begin(),
                   [&](int m) { return centre[static_cast<std::size_t>(m)]; });
    const auto [least, most] = std::minmax_element(around.begin(), around.end());
    if (*most <= -reach) {
      fine.block_of[n] = DistanceSamples::behind_block;
    } else if (*least < reach) {
      const Index block = fine.own(number);
      interpolate(around, reach, fine.distance.block(block), fine.side.block(block));
      fine.limited.push_back(number);
    }
  }
}

}  // namespace

DistanceSamples wall_distance(const NearestFeature& wall, const Lattice& lattice, double reach, int threads) {
  DistanceSamples samples(lattice, reach);
  const LatticeBricks& bricks = samples.bricks;
  DistanceSamples coarse(centres(bricks), coarse_reach(bricks, reach));
  const std::vector<TriangleFrame> frames(wall.shapes().begin(), wall.shapes().end());
  // A point behind the wall has the same nearest point as those on the way to it, which are behind as well: what lies
  // farther off is found by going on from brick to brick, and the rest is free.
  std::vector<bool> listed = first_bricks(wall, bricks, reach);
  std::vector<std::uint8_t> near(listed.size());
  std::vector<int> numbers;
  for (int number = 0; number < bricks.count(); ++number)
    if (listed[static_cast<std::size_t>(number)]) numbers.push_back(number);
  for (std::size_t done = 0; done < numbers.size();) {
    const std::size_t last = std::min(numbers.size(), done + at_once);
    Wave wave(std::vector<int>(numbers.data() + done, numbers.data() + last));
    done = last;
    parallel_ranges(static_cast<int>(wave.numbers().size()), threads, [&](int begin, int end) {
      Sampler sampler(wall, frames, bricks, reach);
      wave.sample(sampler, begin, end);
    });
    wave.store(samples, coarse);
    for (std::size_t k = 0; k < wave.numbers().size(); ++k) {
      near[static_cast<std::size_t>(wave.numbers()[k])] = wave.kind(k).near;
      if (!wave.kind(k).behind) continue;
      bricks.around(wave.numbers()[k], [&](int number) {
        if (listed[static_cast<std::size_t>(number)]) return;
        listed[static_cast<std::size_t>(number)] = true;
        numbers.push_back(number);
      });
    }
  }
  join_at_sheet_ends(coarse.bricks.lattice().spacing, coarse_reach(bricks, reach), coarse);
  fill_far(coarse, reach, near, samples);
  join_at_sheet_ends(lattice.spacing, reach, samples);
  return samples;
}

}  // namespace glossa

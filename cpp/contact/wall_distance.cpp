#include "contact/wall_distance.hpp"

#include <cmath>

#include "contact/candidates.hpp"
#include "contact/lattice_bricks.hpp"
#include "contact/sheet_ends.hpp"
#include "core/parallel.hpp"

namespace glossa {
namespace {

/// Samples single bricks.
class Sampler {
 public:
  Sampler(const NearestFeature& wall, const Lattice& lattice, double reach, DistanceSamples& samples)
      : wall_(wall),
        lattice_(lattice),
        bricks_(lattice),
        reach_(reach),
        samples_(samples),
        triangles_(wall.shapes()),
        ends_(wall.ends()) {}

  /// Whether a point of the brick lies behind the wall.
  bool sample(int number) {
    const Brick brick = bricks_[number];
    const Vector3 centre = bricks_.centre(brick);
    const double radius = bricks_.radius(brick);
    const BoxTree::Found found = wall_.nearest_triangle(centre);
    const double nearest = std::sqrt(found.squared);
    behind_ = false;
    if (nearest > reach_ + radius && ends_are_out_of_reach(centre, nearest, radius)) {
      behind_ = wall_.behind(centre, found.item, wall_.shape(found.item).nearest(centre));
      brick.each([&](int i, int j, int k) { set(i, j, k, reach_, behind_ ? Side::behind : Side::front); });
      return behind_;
    }
    triangles_.gather(wall_.tree(), centre, radius, nearest);
    last_ = found.item;
    ends_.clear();
    brick.each([&](int i, int j, int k) { sample_point(i, j, k, centre, radius); });
    return behind_;
  }

 private:
  static constexpr std::size_t few = 300;

  /// Whether sqrt(e^2 - d^2) > reach at every point of a ball whose centre is `nearest` from the wall.
  [[nodiscard]] bool ends_are_out_of_reach(const Vector3& centre, double nearest, double radius) const {
    return wall_.nearest_end(centre, std::hypot(nearest + radius, reach_) + radius).item < 0;
  }

  void set(int i, int j, int k, double distance, Side side) {
    const std::size_t index = lattice_.index(i, j, k);
    samples_.distance[index] = side == Side::behind ? -distance : distance;
    samples_.side[index] = side;
  }

  /// At a point of the ball around the present brick; of a fine wall the tree knows fewer candidates than the ball.
  [[nodiscard]] Index nearest_triangle(const Vector3& x) const {
    if (triangles_.size() <= few) return triangles_.nearest(x).item;
    return wall_.nearest_triangle(x, wall_.shape(last_).squared_distance(x)).item;
  }

  /// e^2 at a point of the ball around the present brick.
  double squared_end_distance(const Vector3& x, const Vector3& centre, double radius) {
    if (ends_.empty()) ends_.gather(wall_.end_tree(), centre, radius, std::sqrt(wall_.nearest_end(centre).squared));
    return ends_.nearest(x).squared;
  }

  void sample_point(int i, int j, int k, const Vector3& centre, double radius) {
    const Vector3 x = lattice_.point(i, j, k);
    const Index t = last_ = nearest_triangle(x);
    const TriangleShape::Point q = wall_.shape(t).nearest(x);
    double distance = std::sqrt(q.squared);
    Side side = Side::front;
    if (wall_.kind(t, q.part) != FeatureKind::interior)
      side = Side::free;
    else if (wall_.behind(x, t, q))
      side = Side::behind;
    if (side == Side::behind && !wall_.ends().empty())
      distance = std::min(distance, std::sqrt(std::max(squared_end_distance(x, centre, radius) - q.squared, 0.0)));
    behind_ = behind_ || side == Side::behind;
    set(i, j, k, std::min(distance, reach_), side);
  }

  const NearestFeature& wall_;
  const Lattice& lattice_;
  LatticeBricks bricks_;
  double reach_;
  DistanceSamples& samples_;
  Candidates<TriangleShape> triangles_;
  Candidates<SegmentShape> ends_;
  Index last_ = 0;  // nearest triangle of the point before
  bool behind_ = false;
};

/// Bricks where behind can begin: within `reach` of a triangle; and, as the wall may go on outside the lattice, those
/// at the lattice's faces that have their centre behind it.
std::vector<bool> first_bricks(const NearestFeature& wall, const LatticeBricks& bricks, double reach) {
  std::vector<bool> chosen(static_cast<std::size_t>(bricks.count()), false);
  for (const TriangleShape& shape : wall.shapes()) {
    Box box;
    for (const Vector3& corner : {shape.a, Vector3(shape.a + shape.ab), Vector3(shape.a + shape.ac)}) box.add(corner);
    bricks.within(box.low - Vector3::Constant(reach), box.high + Vector3::Constant(reach),
                  [&](int number) { chosen[static_cast<std::size_t>(number)] = true; });
  }
  for (int number = 0; number < bricks.count(); ++number) {
    if (chosen[static_cast<std::size_t>(number)] || !bricks.at_face(number)) continue;
    const Vector3 centre = bricks.centre(bricks[number]);
    const Index t = wall.nearest_triangle(centre).item;
    const TriangleShape::Point q = wall.shape(t).nearest(centre);
    chosen[static_cast<std::size_t>(number)] =
        wall.kind(t, q.part) == FeatureKind::interior && wall.behind(centre, t, q);
  }
  return chosen;
}

}  // namespace

DistanceSamples wall_distance(const NearestFeature& wall, const Lattice& lattice, double reach, int threads) {
  DistanceSamples samples{std::vector<double>(lattice.count(), reach), std::vector<Side>(lattice.count(), Side::free)};
  const LatticeBricks bricks(lattice);
  // A point behind the wall has the same nearest point as those on the way to it, which are behind as well: what lies
  // farther off is found by going on from brick to brick, and the rest is free.
  std::vector<bool> listed = first_bricks(wall, bricks, reach);
  std::vector<int> wave;
  for (int number = 0; number < bricks.count(); ++number)
    if (listed[static_cast<std::size_t>(number)]) wave.push_back(number);
  while (!wave.empty()) {
    std::vector<std::uint8_t> behind(wave.size());
    parallel_ranges(static_cast<int>(wave.size()), threads, [&](int begin, int end) {
      Sampler sampler(wall, lattice, reach, samples);
      for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k)
        behind[k] = sampler.sample(wave[k]);
    });
    std::vector<int> next;
    for (std::size_t k = 0; k < wave.size(); ++k)
      if (behind[k] != 0)
        bricks.around(wave[k], [&](int number) {
          if (listed[static_cast<std::size_t>(number)]) return;
          listed[static_cast<std::size_t>(number)] = true;
          next.push_back(number);
        });
    wave = std::move(next);
  }
  join_at_sheet_ends(lattice, reach, samples);
  return samples;
}

}  // namespace glossa

#include "contact/sheet_ends.hpp"

#include <algorithm>

namespace glossa {
namespace {

constexpr double negligible = 1e-6;  // of the spacing: smaller changes are rounding

/// u(x) = min(u(x), u(y) + |x - y|), u = sign phi. Sign -1: x behind, y behind or in front. Sign 1: x not behind, y
/// behind. Every point lowered remembers its y and hands it on to its neighbours (vector propagation: Danielsson 1980,
/// Comput. Graph. Image Process. 14:227).
class Spread {
 public:
  Spread(const Lattice& lattice, double reach, DistanceSamples& samples, int sign)
      : lattice_(lattice), reach_(reach), samples_(samples), sign_(sign), origin_(lattice.count()) {}

  void run() {
    start();
    for (std::size_t number = 0; number < buckets_.size(); ++number)
      for (std::size_t entry = 0; entry < buckets_[number].size(); ++entry) {
        const Index here = buckets_[number][entry];
        if (bucket(u(static_cast<std::size_t>(here))) != number) continue;  // lowered since
        const Place from = place_of(origin_[static_cast<std::size_t>(here)]);
        neighbours(place_of(here), [&](const Place& next, Side side) {
          if ((side == Side::behind) == (sign_ < 0)) offer(next, from);
        });
      }
  }

 private:
  using Place = std::array<int, 3>;

  [[nodiscard]] std::size_t index(const Place& p) const { return lattice_.index(p[0], p[1], p[2]); }
  [[nodiscard]] Place place_of(Index index) const {
    const auto& [nx, ny, nz] = lattice_.size;
    return {index / (ny * nz), index / nz % ny, index % nz};
  }

  [[nodiscard]] double u(std::size_t index) const { return sign_ * samples_.distance[index]; }

  template <class Visit>
  void neighbours(const Place& p, Visit&& visit) const {
    const auto low = [&](std::size_t axis) { return std::max(p[axis] - 1, 0); };
    const auto high = [&](std::size_t axis) { return std::min(p[axis] + 1, lattice_.size[axis] - 1); };
    for (int i = low(0); i <= high(0); ++i)
      for (int j = low(1); j <= high(1); ++j)
        for (int k = low(2); k <= high(2); ++k) visit(Place{i, j, k}, samples_.side[lattice_.index(i, j, k)]);
  }

  /// First offers, from neighbour to neighbour.
  void start() {
    for (std::size_t k = 0; k < samples_.side.size(); ++k) {
      if (samples_.side[k] != Side::behind) continue;
      const Place place = place_of(static_cast<Index>(k));
      neighbours(place, [&](const Place& next, Side side) {
        if (sign_ < 0 && side != Side::free) offer(place, next);
        if (sign_ > 0 && side != Side::behind) offer(next, place);
      });
    }
  }

  void offer(const Place& place, const Place& from) {
    const std::size_t here = index(place), there = index(from);
    const double room = (u(here) - u(there)) / lattice_.spacing - negligible;
    const Vector3 way(place[0] - from[0], place[1] - from[1], place[2] - from[2]);
    if (room <= 0.0 || way.squaredNorm() >= room * room) return;
    const double lowered = u(there) + lattice_.spacing * way.norm();
    samples_.distance[here] = sign_ * lowered;
    origin_[here] = static_cast<Index>(there);
    const std::size_t number = bucket(lowered);
    if (number >= buckets_.size()) buckets_.resize(number + 1);
    buckets_[number].push_back(static_cast<Index>(here));
  }

  /// Points wait in the order of u, in steps of half a spacing, so that hardly one is looked at twice.
  [[nodiscard]] std::size_t bucket(double value) const {
    return static_cast<std::size_t>(std::max(0.0, (value + reach_) / (0.5 * lattice_.spacing)));
  }

  const Lattice& lattice_;
  double reach_;
  DistanceSamples& samples_;
  int sign_;
  std::vector<Index> origin_;  // the y of each point lowered
  std::vector<std::vector<Index>> buckets_;
};

}  // namespace

void join_at_sheet_ends(const Lattice& lattice, double reach, DistanceSamples& samples) {
  Spread(lattice, reach, samples, -1).run();
  Spread(lattice, reach, samples, 1).run();
}

}  // namespace glossa

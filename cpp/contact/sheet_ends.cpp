#include "contact/sheet_ends.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "contact/triangle_lanes.hpp"

namespace glossa {
namespace {

constexpr double negligible = 1e-6;  // of the spacing: smaller changes are rounding
constexpr int edge = LatticeBricks::edge;

using Bits = std::uint8_t;
constexpr Bits front = static_cast<Bits>(Side::front), free_side = static_cast<Bits>(Side::free);
constexpr Bits behind = static_cast<Bits>(Side::behind), beside = static_cast<Bits>(Side::beside), limited = 16;

/// What the points of each brick are, by bits; and with those of the bricks around, where one is behind or beside.
struct Survey {
  std::vector<Bits> own, near;

  explicit Survey(const DistanceSamples& samples) : own(samples.block_of.size()), near(own.size()) {
    std::vector<Bits> of_block(samples.side.values.size() / LatticeBricks::volume);
    for (std::size_t block = 0; block < of_block.size(); ++block)
      for (std::size_t k = 0; k < LatticeBricks::volume; ++k)
        of_block[block] |= static_cast<Bits>(samples.side.values[LatticeBricks::volume * block + k]);
    for (std::size_t n = 0; n < own.size(); ++n) own[n] = of_block[static_cast<std::size_t>(samples.block_of[n])];
    for (const int number : samples.limited) own[static_cast<std::size_t>(number)] |= limited;
    for (std::size_t n = 0; n < own.size(); ++n)
      if ((own[n] & (behind | beside)) != 0)
        samples.bricks.around(static_cast<int>(n), [&](int other) { near[n] |= own[static_cast<std::size_t>(other)]; });
  }
};

/// u(x) = min(u(x), u(y) + |x - y|), u = sign phi. Sign -1: x behind, y behind or in front. Sign 1: x not behind, y
/// behind or beside. Every point lowered remembers its y and hands it on to its neighbours (vector propagation:
/// Danielsson 1980, Comput. Graph. Image Process. 14:227).
class Spread {
 public:
  Spread(double spacing, double reach, DistanceSamples& samples, int sign)
      : bricks_(samples.bricks),
        spacing_(spacing),
        reach_(reach),
        samples_(samples),
        sign_(sign),
        origin_(samples.distance.values.size()) {
    for (std::size_t axis = 0; axis < 3; ++axis) points_[axis] = edge * bricks_.size()[axis];
  }

  void run(const Survey& survey) {
    // A distance changes by no more than the way: there is something to do only where sides meet, or near curtains.
    const int wanted = sign_ < 0 ? front | limited : front | free_side | beside;
    const int of_own = sign_ < 0 ? behind : behind | beside;
    for (std::size_t n = 0; n < survey.own.size(); ++n)
      if ((survey.own[n] & of_own) != 0 && (survey.near[n] & wanted) != 0) start(static_cast<int>(n));
    for (std::size_t number = 0; number < buckets_.size(); ++number)
      for (std::size_t entry = 0; entry < buckets_[number].size(); ++entry) {
        const Place here = buckets_[number][entry];
        const std::size_t value = samples_.entry_of(here);
        const Place from = origin_[value];                    // a copy: origins move as bricks are given values
        if (bucket(u(value)) == number) hand_on(here, from);  // else lowered since
      }
  }

 private:
  using Place = LatticeBricks::Place;

  [[nodiscard]] bool holds(const Place& p) const {
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) inside = inside && p[axis] >= 0 && p[axis] < points_[axis];
    return inside;
  }
  [[nodiscard]] double u(std::size_t entry) const { return sign_ * samples_.distance.values[entry]; }

  /// Offers y to the neighbours of a point that lie farther from it.
  void hand_on(const Place& here, const Place& from) {
    Place low{}, high{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = here[axis] > from[axis] ? here[axis] : std::max(here[axis] - 1, 0);
      high[axis] = here[axis] < from[axis] ? here[axis] : std::min(here[axis] + 1, points_[axis] - 1);
    }
    const double there = u(samples_.entry_of(from));
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k) {
          const Place next{i, j, k};
          const std::size_t entry = samples_.entry_of(next);
          if ((samples_.side.values[entry] == Side::behind) == (sign_ < 0)) offer(next, entry, from, there);
        }
  }

  /// Whether an offer may pass between a point of a brick and its neighbour, by their sides: with sign -1 from the
  /// neighbour, with sign 1 to it.
  [[nodiscard]] bool starts(Side here) const { return here == Side::behind || (sign_ > 0 && here == Side::beside); }
  [[nodiscard]] bool answers(Side there) const {
    return sign_ > 0 ? there != Side::behind : there == Side::front || there == Side::behind;
  }

  /// First offers, between the points of a brick and their neighbours.
  void start(int number) {
    BrickValues<double>::Halo phi;
    BrickValues<Side>::Halo side;
    samples_.distance.halo(bricks_, samples_.block_of, number, phi);
    samples_.side.halo(bricks_, samples_.block_of, number, side);
    // In spacings; beyond all bounds where a point is not of the side asked for.
    constexpr float no = 1e30F;
    Floats here, there;
    const auto per_spacing = static_cast<float>(1.0 / spacing_);
    for (std::size_t k = 0; k < phi.size(); ++k) {
      const float value = static_cast<float>(phi[k]) * per_spacing;
      here[k] = starts(side[k]) ? value : no;
      there[k] = answers(side[k]) ? value : -no;
    }
    for (int way = 0; way < 27; ++way) {
      const Place go{way / 9 - 1, way / 3 % 3 - 1, way % 3 - 1};
      if (go != Place{} && may_rise(here, there, go)) start(number, go);
    }
  }

  using Floats = std::array<float, 216>;

  /// Whether phi may rise by more than the way, from a point `here` of the brick to the one beside it.
  static bool may_rise(const Floats& here, const Floats& there, const Place& go) {
    const auto length = std::sqrt(static_cast<float>(go[0] * go[0] + go[1] * go[1] + go[2] * go[2]));
    const int step = 36 * go[0] + 6 * go[1] + go[2];
    const Four bound = four(length - 1e-5F);  // rounding of distances up to some tens of spacings
    auto rises = Four{} > Four{};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const float* row = here.data() + 36 * i + 6 * j + 43;
        Four from, to;
        std::memcpy(&from, row, sizeof from);
        std::memcpy(&to, there.data() + (row - here.data()) + step, sizeof to);
        rises |= to - from > bound;
      }
    return (rises[0] | rises[1] | rises[2] | rises[3]) != 0;
  }

  /// Offers between a brick's points and their neighbours that way.
  void start(int number, const Place& go) {
    const Place first = bricks_.place_of(number);
    for (int point = 0; point < 64; ++point) {
      Place place{edge * first[0] + point / 16, edge * first[1] + point / 4 % 4, edge * first[2] + point % 4};
      Place next{place[0] + go[0], place[1] + go[1], place[2] + go[2]};
      if (!holds(next) || !starts(samples_.side.values[samples_.entry_of(place)]) ||
          !answers(samples_.side.values[samples_.entry_of(next)]))
        continue;
      if (sign_ > 0) std::swap(place, next);
      offer(place, samples_.entry_of(place), next, u(samples_.entry_of(next)));
    }
  }

  /// To the point `place`, whose value is at `entry`: the point `from`, where u is `there`.
  void offer(const Place& place, std::size_t entry, const Place& from, double there) {
    const double room = (u(entry) - there) / spacing_ - negligible;
    const Vector3 way(place[0] - from[0], place[1] - from[1], place[2] - from[2]);
    if (room <= 0.0 || way.squaredNorm() >= room * room) return;
    if (entry < LatticeBricks::volume * static_cast<std::size_t>(samples_.distance.shared)) {
      samples_.own(samples_.brick_of(place));
      origin_.resize(samples_.distance.values.size());
      entry = samples_.entry_of(place);
    }
    const double lowered = there + spacing_ * way.norm();
    samples_.distance.values[entry] = sign_ * lowered;
    origin_[entry] = from;
    const std::size_t number = bucket(lowered);
    if (number >= buckets_.size()) buckets_.resize(number + 1);
    buckets_[number].push_back(place);
  }

  /// Points wait in the order of u, in steps of half a spacing, so that hardly one is looked at twice.
  [[nodiscard]] std::size_t bucket(double value) const {
    return static_cast<std::size_t>(std::max(0.0, (value + reach_) / (0.5 * spacing_)));
  }

  const LatticeBricks& bricks_;
  double spacing_, reach_;
  DistanceSamples& samples_;
  int sign_;
  Place points_{};
  std::vector<Place> origin_;  // the y of each point lowered
  std::vector<std::vector<Place>> buckets_;
};

}  // namespace

void join_at_sheet_ends(double spacing, double reach, DistanceSamples& samples) {
  const Survey survey(samples);
  Spread(spacing, reach, samples, -1).run(survey);
  Spread(spacing, reach, samples, 1).run(survey);
}

}  // namespace glossa

// The signed distance of a wall at the points of a lattice: positive on the tongue's side, negative in the wall.
//
// Closed wall: the ordinary signed distance. Open wall: the front of a thick plate whose sides, the curtains, run
// backwards from its ends along the surface normals (an end is a rim or an edge of inconsistent faces), so that space
// beyond the ends is free. With d the distance to the wall, e the distance to its ends, q the nearest point:
//   front   q interior, x in front of it    phi = d
//   behind  q interior, x behind it         phi = -min(d, sqrt(e^2 - d^2)), the second the distance to the curtain,
//                                           exact for a plane; it vanishes where an end becomes the nearest
//   free    q on an end                     phi = d, until what is behind lowers it to the distance to the curtain
// Then phi is made 1-Lipschitz, so that it has no jump whatever the shape of the ends: behind, phi is raised to
// phi(y) - |x - y| of the points y in front and behind; elsewhere it is lowered to phi(y) + |x - y| of those behind.
// In front of a wall that bounds one side this changes nothing, since the way to a point behind leads through the wall.
// Where it does not (a sheet rolled up, a seam of faces turned round) the front wins. Far behind an open wall a point
// is in the plate as long as its nearest point is not on an end.
//
// Distances are exact at the points of bricks that come within reach of the wall. Of other bricks only the centre is
// looked at; where it is behind, or beside the plate, values between centres are interpolated: so the plate's curtains
// are known to half a brick there, and still without jumps.
#pragma once

#include "contact/lattice_bricks.hpp"
#include "contact/nearest_feature.hpp"

namespace glossa {

/// By bits, so that those of many points can be joined. Beside: free, and its phi is already a distance from a curtain.
enum class Side : std::uint8_t { front = 1, free = 2, behind = 4, beside = 8 };

/// By brick. The shared blocks are free and front at +reach, and behind at -reach.
struct DistanceSamples {
  explicit DistanceSamples(const Lattice& lattice, double reach)
      : bricks(lattice),
        block_of(static_cast<std::size_t>(bricks.count()), free_block),
        distance(std::vector<double>{reach, reach, -reach}),
        side(std::vector<Side>{Side::free, Side::front, Side::behind}) {}

  static constexpr Index free_block = 0, front_block = 1, behind_block = 2;

  LatticeBricks bricks;
  std::vector<Index> block_of;   // of each brick
  BrickValues<double> distance;  // m, within [-reach, reach]
  BrickValues<Side> side;        // in the same blocks
  std::vector<int> limited;      // bricks with a point behind that the curtain is nearer to than the wall

  /// Gives a brick a block of its own unless it has one; its block.
  Index own(int number) {
    Index& block = block_of[static_cast<std::size_t>(number)];
    if (block < distance.shared) {
      side.copy(block);
      block = distance.copy(block);
    }
    return block;
  }
  [[nodiscard]] int brick_of(const LatticeBricks::Place& point) const {
    constexpr int edge = LatticeBricks::edge;
    return bricks.number_of(point[0] / edge, point[1] / edge, point[2] / edge);
  }
  /// Where the values of a point are.
  [[nodiscard]] std::size_t entry_of(const LatticeBricks::Place& point) const {
    return LatticeBricks::volume * static_cast<std::size_t>(block_of[static_cast<std::size_t>(brick_of(point))]) +
           LatticeBricks::offset_of(point[0], point[1], point[2]);
  }
};

/// Exact within `reach` (m) of the wall, +reach or -reach beyond but for the curtains. Same bits for every number of
/// threads.
[[nodiscard]] DistanceSamples wall_distance(const NearestFeature& wall, const Lattice& lattice, double reach,
                                            int threads);

}  // namespace glossa

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
#pragma once

#include "contact/lattice.hpp"
#include "contact/nearest_feature.hpp"

namespace glossa {

enum class Side : std::uint8_t { front, free, behind };

struct DistanceSamples {
  std::vector<double> distance;  // m, within [-reach, reach]
  std::vector<Side> side;
};

/// Exact within `reach` (m) of the wall, +reach or -reach beyond. Same bits for every number of threads.
[[nodiscard]] DistanceSamples wall_distance(const NearestFeature& wall, const Lattice& lattice, double reach,
                                            int threads);

}  // namespace glossa

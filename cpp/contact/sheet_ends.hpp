// Makes sampled distances continuous where a sheet ends: what wall_distance.hpp says of free points and of the front.
#pragma once

#include "contact/wall_distance.hpp"

namespace glossa {

/// Raises samples behind to phi(y) - |x - y| of all others that are not free, then lowers the rest to
/// phi(y) + |x - y| of those behind or beside, y running over lattice points; none changes where phi was a distance
/// from one surface without ends. Afterwards phi is 1-Lipschitz. Serial; all |phi| <= reach (m).
void join_at_sheet_ends(double spacing, double reach, DistanceSamples& samples);

}  // namespace glossa

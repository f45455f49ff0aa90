// Macrofibres for the tests.
#pragma once

#include "../fixture.hpp"
#include "muscle/macrofibre.hpp"

namespace glossa::test {

inline void add_fibre(Macrofibres& fibres, Index muscle, const std::vector<Index>& path, double capacity,
                      double length_factor, const NodeField& rest, const std::vector<Stiffened>& stiffened = {}) {
  fibres.nodes.values.insert(fibres.nodes.values.end(), path.begin(), path.end());
  fibres.nodes.push_row();
  fibres.stiffened.values.insert(fibres.stiffened.values.end(), stiffened.begin(), stiffened.end());
  fibres.stiffened.push_row();
  fibres.muscle.push_back(muscle);
  fibres.capacity.push_back(capacity);
  fibres.length_factor.push_back(length_factor);
  fibres.rest_length.push_back(0.0);
  fibres.rest_length.back() = fibre_length(fibres, fibres.count() - 1, rest);
}

/// Three muscles in block(2, 2, 2, ..., one outside node): a bent fibre, one of a half model that continues beyond the
/// mirror plane, and one that comes from the outside point 27.
inline Macrofibres three_fibres(const HexMesh& mesh) {
  Macrofibres fibres;
  add_fibre(fibres, 0, {4, 13, 23, 26}, 2.0, 1.0, mesh.nodes(), {{0, 80.0}, {3, 40.0}});
  add_fibre(fibres, 1, {9, 13, 17}, 3.0, 2.0, mesh.nodes(), {{3, 100.0}, {7, 100.0}});
  add_fibre(fibres, 2, {27, 12, 13}, 5.0, 1.0, mesh.nodes());
  return fibres;
}

}  // namespace glossa::test

// Macrofibres: polylines of mesh nodes under one tension.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// An element that a macrofibre stiffens, with the product p1(m) p2(f, e) of eq. 1.
struct Stiffened {
  Index element;
  double gain;  ///< 1/m
};

/// The macrofibres of all muscles, one row each.
///
/// length_factor: 1, or 2 for a fibre of a half model that continues symmetrically on the other side: its length in
/// eq. 2 is twice the length of its half. capacity: rho_fib of eq. 4 in N, halved for a fibre lying in the mirror plane
/// of a half model.
struct Macrofibres {
  Rows<Index> nodes;
  std::vector<Index> muscle;
  std::vector<double> capacity;
  std::vector<double> length_factor;
  std::vector<double> rest_length;  ///< m, length factor included
  Rows<Stiffened> stiffened;

  [[nodiscard]] Index count() const { return nodes.size(); }
};

/// Length of fibre f at the given node positions (m), length factor included.
double fibre_length(const Macrofibres& fibres, Index f, const NodeField& positions);

/// Rate of that length (m/s) for the given node velocities (m/s).
double fibre_rate(const Macrofibres& fibres, Index f, const NodeField& positions, const NodeField& velocities);

/// Derivative of the length of the polyline (without length factor) with respect to its nodes, in path order.
void fibre_gradient(const Macrofibres& fibres, Index f, const NodeField& positions, std::vector<Vector3>& gradient);

/// Second derivative of the length of one segment from `a` to `b` (positions, m) with respect to b: (1 - n n') / length.
Matrix3 segment_curvature(const Vector3& a, const Vector3& b);

}  // namespace glossa

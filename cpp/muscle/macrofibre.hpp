// Macrofibres: polylines of mesh nodes under one tension.
//
// A segment that a strong pull shortens to nothing would turn its direction about: the force jumps and equilibrium lies
// on the kink. Segment lengths are therefore softened, sqrt(d^2 + (0.01 d0)^2) minus what that adds at rest: the rest
// length d0 is kept exactly, a segment at half its length is 1e-4 shorter, and one below a few percent of d0 stops
// pulling smoothly.
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
  std::vector<double>
      segment_rest;  ///< m, for each entry of nodes.values the segment that starts there; empty: not soft

  [[nodiscard]] Index count() const { return nodes.size(); }
};

/// Length of fibre f at the given node positions (m), length factor included.
double fibre_length(const Macrofibres& fibres, Index f, const NodeField& positions);

/// Rate of that length (m/s) for the given node velocities (m/s).
double fibre_rate(const Macrofibres& fibres, Index f, const NodeField& positions, const NodeField& velocities);

/// Derivative of the length of the polyline (without length factor) with respect to its nodes, in path order.
void fibre_gradient(const Macrofibres& fibres, Index f, const NodeField& positions, std::vector<Vector3>& gradient);

/// One segment of a fibre at some positions.
struct Segment {
  Vector3
      direction;   ///< derivative of the softened length with respect to the far end; a unit vector but for softening
  double length;   ///< m, softened
  double divisor;  ///< m, sqrt(d^2 + softening^2)

  /// Second derivative of the length with respect to the far end, 1/m.
  [[nodiscard]] Matrix3 curvature() const {
    return (Matrix3::Identity() - direction * direction.transpose()) / divisor;
  }
};

/// Segment k (from the k-th node to the next) of fibre f.
Segment fibre_segment(const Macrofibres& fibres, Index f, Index k, const NodeField& positions);

/// Sets segment_rest from rest positions.
void soften_segments(Macrofibres& fibres, const NodeField& rest);

}  // namespace glossa

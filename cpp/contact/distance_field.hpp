// A smooth signed distance of a wall: what contact needs of it.
//
// The signed distance of wall_distance.hpp (closed walls; open ones as the front of a thick plate) is clipped to a
// band, sampled on a lattice and splined (spline_grid.hpp): value, gradient and Hessian are continuous, as Newton's
// method wants them. Nearest points of the triangles themselves stall it.
//
// What smoothing changes: |phi| in mm on the walls of the PB speaker within 15 mm of the tongue, 2 mm and more away
// from edges above 30 degrees, and anywhere; and the CPU time of building the field in s (one thread of a busy two-core
// virtual machine; 1e6 lattice points at 1 mm).
//
//   wall (triangles)           spacing   off edges: mean, p95, max   anywhere: mean, p95, max   time
//   hard palate, teeth (878)   0.8 mm    0.006  0.020  0.07          0.017  0.072  0.29         0.4
//                              1.0       0.008  0.028  0.13          0.024  0.098  0.37         0.2
//                              1.25      0.013  0.041  0.14          0.034  0.138  0.45         0.15
//   soft palate, pharynx       0.8       0.006  0.021  0.07          0.012  0.047  0.26         0.6
//   above z = 57 mm (1490)     1.0       0.009  0.029  0.10          0.018  0.065  0.40         0.3
//                              1.25      0.013  0.041  0.11          0.025  0.090  0.43         0.25
//   mandible, teeth (2774)     0.8       0.005  0.019  0.06          0.009  0.036  0.28         0.35
//                              1.0       0.008  0.027  0.09          0.014  0.051  0.33         0.2
//                              1.25      0.011  0.038  0.14          0.020  0.071  0.57         0.15
//
// A sphere of 10 mm, a cylinder and a vault are held to a few micrometres. A right-angled edge is rounded by 0.19
// spacings, tips of teeth more; curvatures reach 2.8 per mm (95 % below 1.4 within 0.5 mm of a wall), slopes 1.35.
#pragma once

#include "contact/nearest_feature.hpp"
#include "contact/spline_grid.hpp"

namespace glossa {

struct DistanceFieldOptions {
  double spacing = 1e-3;          ///< m, of the lattice
  double band = 6e-3;             ///< m, distances are clipped to [-band, band]; at least 4 spacings
  Vector3 low = Vector3::Zero();  ///< m, corners of the box of interest
  Vector3 high = Vector3::Zero();
  int threads = 1;
};

/// Positive on the tongue's side, negative inside the wall; immutable. A wall that overlaps itself is no union of its
/// parts: the nearest one decides.
///
/// Beyond the box every point is free: +band, without slope. The clip is smooth, 1.5 spacings to either side of the
/// band (with 6 mm and 1 mm: phi is off by 6 um at 4 mm, 0.02 mm at most where it is flat): a point deeper than that
/// reads -band without slope, and the way out is not known there. NaN for NaN. The same bits for every number of
/// threads and every order of vertices and triangles.
class DistanceField {
 public:
  /// InputError: what wall_topology refuses; options that are not finite or out of range; a lattice of more than
  /// 4e7 points.
  DistanceField(const WallSurface& wall, const DistanceFieldOptions& options);

  /// Distance, m.
  [[nodiscard]] double distance(const Vector3& x) const;
  double value(const Vector3& x, Vector3& gradient) const;
  double value(const Vector3& x, Vector3& gradient, Matrix3& hessian) const;  ///< Hessian in 1/m

  [[nodiscard]] double spacing() const { return spline_.lattice().spacing; }
  [[nodiscard]] double band() const { return band_; }
  /// How well the surface was kept: 95th percentile of |phi| (m) over the centroids and the vertices off the rims of
  /// the triangles inside the box; vertices on edges are where it is worst. 0 if there are none.
  [[nodiscard]] double geometric_error() const { return geometric_error_; }

 private:
  double band_;
  SplineGrid spline_;
  double geometric_error_ = 0.0;
};

}  // namespace glossa

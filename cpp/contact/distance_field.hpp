// A smooth signed distance of a wall: what contact needs of it.
//
// The signed distance of wall_distance.hpp (closed walls; open ones as the front of a thick plate) is clipped to a
// band, sampled on a lattice and splined (spline_grid.hpp): value, gradient and Hessian are continuous, as Newton's
// method wants them. Nearest points of the triangles themselves stall it.
//
// What smoothing changes: |phi| in mm over the area of the walls within 15 mm of where the tongue may touch them, apart
// from edges (2 mm and more away from rims and from edges above 30 degrees) and near them, where rounding is wanted;
// and the CPU time of building the field in s (one thread of a busy two-core virtual machine).
//
//   wall (triangles)                 spacing   apart: p95, max   near edges: p95, max   anywhere: p95   time
//   PB hard palate, teeth (878)      0.8 mm    0.018  0.07       0.107  0.33            0.064           0.12
//                                    1.0       0.026  0.12       0.152  0.40            0.094           0.08
//   PB soft palate, pharynx (1490)   0.8       0.020  0.07       0.076  0.28            0.046           0.14
//                                    1.0       0.026  0.10       0.105  0.36            0.064           0.08
//   PB mandible, teeth (2774)        0.8       0.018  0.06       0.051  0.20            0.029           0.24
//                                    1.0       0.025  0.08       0.069  0.26            0.042           0.16
//   built-in hard palate (4416)      0.8       0.009  0.03       0.124  0.28            0.023           0.20
//   built-in soft palate (2208)      0.8       0.005  0.02       0.111  0.28            0.036           0.11
//   built-in pharynx (3168)          0.8       0.007  0.02       0.125  0.28            0.031           0.13
//   built-in mandible (7040)         0.8       0.015  0.06       0.078  0.30            0.029           0.33
//
// A sphere of 10 mm, a cylinder and a vault are held to a few micrometres. A right-angled edge is rounded by 0.19
// spacings, tips of teeth more. Curvatures at 0.8 mm are below 0.8 per mm apart from edges, up to 3.0 at them; slopes
// there reach 1.15.
//
// Building: exact distances in bricks of the lattice that come within band and clip of the wall, one for each brick
// farther off (wall_distance.hpp), one value for all bricks beyond; the time goes with the wall's area.
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
/// Told up to the band, without a warning beyond it: a point farther from the wall reads +band and one deeper in it
/// reads -band, both without slope, so that the way out is not known there. The clip is smooth, 1.5 spacings to either
/// side of the band (with 6 mm and 1 mm: phi is off by 6 um at 4 mm, 0.02 mm at most where it is flat). Beyond the box
/// every point is free: +band, without slope, also behind the wall. NaN for NaN. The same bits for every number of
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
  /// Value and gradient with a cell that this field alone has filled (spline_grid.hpp).
  double value(const Vector3& x, Vector3& gradient, SplineCell& cell) const;

  [[nodiscard]] double spacing() const { return spline_.lattice().spacing; }
  [[nodiscard]] double band() const { return band_; }
  /// How well the surface was kept inside the box: 95 % of its area, 2 mm and more away from rims and edges of more
  /// than 30 degrees, is within this distance (m) of phi = 0. 0 if there is none.
  [[nodiscard]] double geometric_error() const { return geometric_error_; }
  /// The same of what lies nearer to rims and such edges, which are rounded.
  [[nodiscard]] double edge_rounding() const { return edge_rounding_; }

 private:
  double band_;
  SplineGrid spline_;
  double geometric_error_ = 0.0, edge_rounding_ = 0.0;
};

}  // namespace glossa

// A wall's surface in canonical form: welded, sorted, with edges, rims and pseudo-normals.
//
// Vertices are sorted by position, every triangle starts at its lowest vertex, triangles are sorted: whatever is
// computed from here on has the same bits for every order of vertices and faces.
//
// Angle-weighted pseudo-normals (Baerentzen & Aanaes 2005, IEEE Trans. Vis. Comput. Graph. 11:243): the sign of
// (x - q) . n is the side of x when q is the nearest point, for n of the face, the sum of both faces at an edge, the
// sum over the fan weighted by the corner angles at a vertex.
#pragma once

#include "contact/wall_surface.hpp"

namespace glossa {

/// What surrounds an edge: two faces that agree; one face; two that run the same way round, or three and more.
/// A vertex is inconsistent or on the rim where one of its edges is.
enum class FeatureKind : std::uint8_t { interior, rim, inconsistent };

struct WallEdge {
  Index a, b;
  FeatureKind kind;
  Vector3 normal;  // sum of the normals of its faces
};

struct WallTopology {
  std::vector<Vector3> vertices;
  std::vector<Triangle> triangles;
  std::vector<Index> source;                // number of each triangle in the surface given
  std::vector<std::array<Index, 3>> sides;  // edges of each triangle; side k joins corners k and k + 1
  std::vector<WallEdge> edges;              // sorted by (a, b), a < b
  std::vector<Vector3> face_normals;        // unit
  std::vector<Vector3> vertex_normals;      // weighted sums
  std::vector<FeatureKind> vertex_kinds;

  /// No rim and no inconsistent edge.
  [[nodiscard]] bool closed() const;
};

/// Vertices nearer than this are one, m.
inline constexpr double welding_distance = 1e-7;

/// InputError, naming vertex or triangle: no triangle, a coordinate that is not finite, an index out of range, corners
/// that coincide once welded or lie on one line.
[[nodiscard]] WallTopology wall_topology(const WallSurface& surface);

}  // namespace glossa

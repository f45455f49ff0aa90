// A checked body of hexahedra at rest.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// Nodes (rest positions, m) and hexahedra (VTK order). Immutable; the constructor refuses with InputError, naming
/// node or element: non-finite coordinates, indices out of range, a node twice in one hexahedron, no hexahedron, and
/// hexahedra whose Jacobian is not positive at every corner and Gauss point.
/// Nodes in no hexahedron are fixed outside points (the styloid process) that only macrofibres pass through.
class HexMesh {
 public:
  HexMesh(NodeField nodes, std::vector<Hexahedron> hexahedra);

  [[nodiscard]] Index node_count() const { return static_cast<Index>(nodes_.size() / 3); }
  [[nodiscard]] Index element_count() const { return static_cast<Index>(hexahedra_.size()); }
  [[nodiscard]] const NodeField& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<Hexahedron>& hexahedra() const { return hexahedra_; }
  /// Volume of one element by the 2 x 2 x 2 rule, m3.
  [[nodiscard]] double volume(Index element) const { return volumes_[static_cast<std::size_t>(element)]; }
  /// Longest edge of the bounding box of the hexahedra, m: the size of the body, the same for a mirrored half.
  [[nodiscard]] double extent() const { return extent_; }
  /// True where the node belongs to no hexahedron.
  [[nodiscard]] bool outside(Index node) const { return outside_[static_cast<std::size_t>(node)]; }

 private:
  NodeField nodes_;
  std::vector<Hexahedron> hexahedra_;
  std::vector<double> volumes_;
  std::vector<bool> outside_;
  double extent_ = 0.0;
};

}  // namespace glossa

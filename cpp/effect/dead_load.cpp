#include "effect/dead_load.hpp"

#include <Eigen/LU>

#include "mesh/hex_element.hpp"

namespace glossa {

NodeField gravity_load(const HexMesh& mesh, double density, const Vector3& gravity) {
  NodeField load(mesh.nodes().size(), 0.0);
  for (const Hexahedron& element : mesh.hexahedra())
    for (std::size_t q = 0; q < hex::points; ++q) {
      const auto xi = hex::gauss_point(q);
      const hex::CornerGradients gradient = hex::shape_gradient(xi);
      Matrix3 jacobian = Matrix3::Zero();
      for (std::size_t a = 0; a < hex::corners; ++a)
        jacobian += at(mesh.nodes(), element[a]) * gradient.col(static_cast<Eigen::Index>(a)).transpose();
      const double mass = density * jacobian.determinant();
      const hex::CornerValues n = hex::shape(xi);
      for (std::size_t a = 0; a < hex::corners; ++a)
        Eigen::Map<Vector3>(load.data() + 3 * element[a]) += mass * n[a] * gravity;
    }
  return load;
}

NodeField gravity_load(const Cells& cells, const std::vector<double>& masses, Index node_count,
                       const Vector3& gravity) {
  NodeField load(3 * static_cast<std::size_t>(node_count), 0.0);
  const auto add = [&](Index node, double mass) { Eigen::Map<Vector3>(load.data() + 3 * node) += mass * gravity; };
  std::size_t pair = 0;
  for (std::size_t c = 0; c < cells.count(); ++c)
    for (std::size_t b = 0; b < cells.size; ++b)
      for (std::size_t a = 0; a <= b; ++a, ++pair) {
        add(cells.begin(c)[a], masses[pair]);
        if (a != b) add(cells.begin(c)[b], masses[pair]);
      }
  return load;
}

}  // namespace glossa

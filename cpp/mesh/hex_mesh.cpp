#include "mesh/hex_mesh.hpp"

#include <algorithm>
#include <sstream>

#include <Eigen/LU>

#include "core/error.hpp"
#include "mesh/hex_element.hpp"

namespace glossa {
namespace {

Matrix3 jacobian(const NodeField& nodes, const Hexahedron& hexahedron, const std::array<double, 3>& xi) {
  const hex::CornerGradients gradient = hex::shape_gradient(xi);
  Matrix3 result = Matrix3::Zero();
  for (std::size_t a = 0; a < hex::corners; ++a)
    result += at(nodes, hexahedron[a]) * gradient.col(static_cast<Eigen::Index>(a)).transpose();
  return result;
}

void check_indices(const std::vector<Hexahedron>& hexahedra, Index node_count) {
  for (std::size_t e = 0; e < hexahedra.size(); ++e) {
    for (const Index node : hexahedra[e])
      require(node >= 0 && node < node_count, "hexahedron " + std::to_string(e) + ": node index " +
                                                  std::to_string(node) + " is outside 0.." +
                                                  std::to_string(node_count - 1));
    Hexahedron sorted = hexahedra[e];
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    require(twice == sorted.end(), "hexahedron " + std::to_string(e) + ": node " +
                                       std::to_string(twice == sorted.end() ? -1 : *twice) +
                                       " appears more than once; collapsed hexahedra are not supported");
  }
}

double least_jacobian(const NodeField& nodes, const Hexahedron& hexahedron) {
  double least = jacobian(nodes, hexahedron, hex::gauss_point(0)).determinant();
  for (std::size_t q = 0; q < hex::points; ++q) {
    least = std::min(least, jacobian(nodes, hexahedron, hex::gauss_point(q)).determinant());
    least = std::min(least, jacobian(nodes, hexahedron, hex::corner[q]).determinant());
  }
  return least;
}

}  // namespace

HexMesh::HexMesh(NodeField nodes, std::vector<Hexahedron> hexahedra)
    : nodes_(std::move(nodes)), hexahedra_(std::move(hexahedra)) {
  require(nodes_.size() % 3 == 0, "mesh: three coordinates per node are needed");
  require(!hexahedra_.empty(), "mesh: at least one hexahedron is needed");
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    require(std::isfinite(nodes_[k]), "node " + std::to_string(k / 3) + ": its coordinates must be finite");
  check_indices(hexahedra_, node_count());
  outside_.assign(nodes_.size() / 3, true);
  volumes_.reserve(hexahedra_.size());
  for (std::size_t e = 0; e < hexahedra_.size(); ++e) {
    const double least = least_jacobian(nodes_, hexahedra_[e]);
    if (!(least > 0.0)) {
      std::ostringstream message;
      message << "hexahedron " << e << ": inverted or degenerate, its smallest Jacobian is " << least
              << " m3 and must be positive; corners follow the VTK order (bottom face anticlockwise seen from the top, "
                 "then the top face)";
      throw InputError(message.str());
    }
    double volume = 0.0;
    for (std::size_t q = 0; q < hex::points; ++q)
      volume += jacobian(nodes_, hexahedra_[e], hex::gauss_point(q)).determinant();
    volumes_.push_back(volume);
    for (const Index node : hexahedra_[e]) outside_[static_cast<std::size_t>(node)] = false;
  }
  Vector3 low = at(nodes_, hexahedra_[0][0]), high = low;
  for (Index n = 0; n < node_count(); ++n) {
    if (outside(n)) continue;
    low = low.cwiseMin(at(nodes_, n));
    high = high.cwiseMax(at(nodes_, n));
  }
  extent_ = (high - low).maxCoeff();
}

}  // namespace glossa

// Names for the arrays that cross the rooms.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/index.hpp"

namespace glossa {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector = Eigen::VectorXd;

/// Eight corner nodes of a hexahedron in VTK order.
using Hexahedron = std::array<Index, 8>;

/// A field of one 3-vector per node, flat: entry 3 n + i is component i of node n.
using NodeField = std::vector<double>;

inline Vector3 at(const NodeField& field, Index node) {
  return Eigen::Map<const Vector3>(field.data() + 3 * static_cast<std::size_t>(node));
}

/// A list of lists, flat: row r is values[start[r]] ... values[start[r + 1] - 1].
template <class T>
struct Rows {
  std::vector<Index> start{0};
  std::vector<T> values;

  [[nodiscard]] Index size() const { return static_cast<Index>(start.size()) - 1; }
  [[nodiscard]] Index length(Index row) const {
    return start[static_cast<std::size_t>(row) + 1] - start[static_cast<std::size_t>(row)];
  }
  [[nodiscard]] const T* begin(Index row) const { return values.data() + start[static_cast<std::size_t>(row)]; }
  [[nodiscard]] const T* end(Index row) const { return values.data() + start[static_cast<std::size_t>(row) + 1]; }
  void push_row() { start.push_back(static_cast<Index>(values.size())); }
};

}  // namespace glossa

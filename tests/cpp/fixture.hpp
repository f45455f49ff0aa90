// What the tests share: tolerances that can be read out, seeded random numbers, small bodies.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "core/error.hpp"
#include "core/types.hpp"
#include "effect/block_matrix.hpp"
#include "mesh/hex_mesh.hpp"

// Passes where `residual` is at most `tolerance`; NaN fails. With GLOSSA_RESIDUALS set in the environment every
// comparison prints what it found, so that a tolerance can be held against the residual it allows for.
#define CHECK_WITHIN(residual, tolerance)                                            \
  do {                                                                               \
    const double residual_found = (residual);                                        \
    ::glossa::test::print_residual(__FILE__, __LINE__, residual_found, (tolerance)); \
    CHECK(residual_found <= (tolerance));                                            \
  } while (false)

namespace glossa::test {

inline void print_residual(const char* file, int line, double residual, double tolerance) {
  static const bool wanted = std::getenv("GLOSSA_RESIDUALS") != nullptr;
  if (wanted) std::printf("%s:%d: %.2e of %.0e\n", file, line, residual, tolerance);
}

/// Uniform numbers that are the same on every platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Matrix3 matrix(double size) {
    Matrix3 result;
    for (double& x : result.reshaped()) x = (*this)(-size, size);
    return result;
  }
  NodeField field(std::size_t size, double amplitude) {
    NodeField result(size);
    for (double& x : result) x = (*this)(-amplitude, amplitude);
    return result;
  }

 private:
  std::mt19937_64 engine_;
};

inline Eigen::Map<const Vector> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

/// Largest entry of a - b over the largest entry of b, which must not vanish.
template <class A, class B>
double worst_entry(const A& a, const B& b) {
  const double reference = b.cwiseAbs().maxCoeff();
  REQUIRE(reference > 0.0);
  return (a - b).cwiseAbs().maxCoeff() / reference;
}
inline double worst_entry(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  return worst_entry(as_vector(a), as_vector(b));
}

/// df/dx by differences of fourth order: truncation h^4, rounding eps / h.
template <class Function>
auto derivative(Function&& f, double h) {
  const auto near_step = (f(h) - f(-h)).eval();
  const auto far_step = (f(2 * h) - f(-2 * h)).eval();
  return ((8.0 * near_step - far_step) / (12.0 * h)).eval();
}
template <class Function>
double slope(Function&& f, double h) {
  return (8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12.0 * h);
}

/// A block of nx x ny x nz cells (edge `cell`, m), its inner and outer nodes moved at random by up to `distortion` of
/// an edge. Node (i, j, k) has the number i + (nx + 1) (j + (ny + 1) k). `outside` further nodes belong to no
/// hexahedron.
inline HexMesh block(Index nx, Index ny, Index nz, double distortion = 0.0, double cell = 0.01, Index outside = 0) {
  Random random(7);
  NodeField nodes;
  for (Index k = 0; k <= nz; ++k)
    for (Index j = 0; j <= ny; ++j)
      for (Index i = 0; i <= nx; ++i)
        for (const Index step : {i, j, k}) nodes.push_back(cell * (step + random(-distortion, distortion)));
  for (Index n = 0; n < outside; ++n) nodes.insert(nodes.end(), {-2.3 * cell, 0.4 * cell, (1.7 + n) * cell});
  const auto node = [&](Index i, Index j, Index k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  std::vector<Hexahedron> hexahedra;
  for (Index k = 0; k < nz; ++k)
    for (Index j = 0; j < ny; ++j)
      for (Index i = 0; i < nx; ++i)
        hexahedra.push_back({node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k),
                             node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
                             node(i, j + 1, k + 1)});
  return {std::move(nodes), std::move(hexahedra)};
}

/// The image of the nodes under x -> F x + shift.
inline NodeField mapped(const NodeField& nodes, const Matrix3& F, const Vector3& shift = Vector3::Zero()) {
  NodeField result(nodes.size());
  for (std::size_t n = 0; n < nodes.size() / 3; ++n)
    Eigen::Map<Vector3>(result.data() + 3 * n) = F * at(nodes, static_cast<Index>(n)) + shift;
  return result;
}

inline NodeField sum(const NodeField& a, const NodeField& b, double factor = 1.0) {
  NodeField result(a);
  for (std::size_t k = 0; k < a.size(); ++k) result[k] += factor * b[k];
  return result;
}

/// A proper rotation, general.
inline Matrix3 rotation() {
  const Vector3 axis = Vector3(1.0, -2.0, 0.5).normalized();
  Matrix3 cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  const double angle = 0.9;
  return Matrix3::Identity() + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

/// Every component free but those of the nodes with the lowest number of a block: the face k = 0.
inline FreeMask bottom_held(const HexMesh& mesh, Index nx, Index ny) {
  FreeMask free(mesh.nodes().size(), 1);
  std::fill_n(free.begin(), 3 * (nx + 1) * (ny + 1), std::uint8_t{0});
  return free;
}

inline std::vector<Index> natural_order(const std::vector<Index>& column_start, const std::vector<Index>&) {
  std::vector<Index> order(column_start.size() - 1);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Index>(k);
  return order;
}

/// Both triangles of a matrix given by the columns of its lower one.
inline Eigen::MatrixXd dense(const LowerColumns& columns) {
  const auto n = static_cast<Eigen::Index>(columns.column_start.size()) - 1;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Index k = columns.column_start[static_cast<std::size_t>(j)];
         k < columns.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      const Index i = columns.row[static_cast<std::size_t>(k)];
      result(i, j) = result(j, i) = columns.value[static_cast<std::size_t>(k)];
    }
  return result;
}

}  // namespace glossa::test

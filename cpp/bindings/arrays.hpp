// numpy arrays at the border.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/types.hpp"

namespace glossa::python {

namespace py = pybind11;

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IntArray = py::array_t<Index, py::array::c_style | py::array::forcecast>;
using ByteArray = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;

template <class T>
std::vector<T> to_vector(const py::array_t<T, py::array::c_style | py::array::forcecast>& array) {
  return std::vector<T>(array.data(), array.data() + array.size());
}

/// A finite (n, 3) array as a node field.
inline NodeField to_field(const DoubleArray& array, const char* name, py::ssize_t nodes = -1) {
  require(array.ndim() == 2 && array.shape(1) == 3 && (nodes < 0 || array.shape(0) == nodes),
          std::string(name) + ": shape must be (" + (nodes < 0 ? "n" : std::to_string(nodes)) + ", 3)");
  NodeField field = to_vector(array);
  for (const double x : field) require(std::isfinite(x), std::string(name) + ": every entry must be finite");
  return field;
}

/// Moves a vector into a numpy array that owns it; `columns` > 0 makes it (n, columns).
inline py::array_t<double> to_array(std::vector<double> values, py::ssize_t columns = 0) {
  auto* kept = new std::vector<double>(std::move(values));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<double>*>(p); });
  const auto size = static_cast<py::ssize_t>(kept->size());
  if (columns == 0) return py::array_t<double>({size}, {sizeof(double)}, kept->data(), owner);
  return py::array_t<double>({size / columns, columns}, kept->data(), owner);
}

/// Vectors one after another.
inline std::vector<double> flat(const std::vector<Vector3>& vectors) {
  std::vector<double> values;
  for (const Vector3& v : vectors) values.insert(values.end(), v.data(), v.data() + 3);
  return values;
}

/// A finite (n, 3) array as vectors; None gives none.
inline std::vector<Vector3> to_vectors(const py::object& array, const char* name) {
  std::vector<Vector3> vectors;
  if (array.is_none()) return vectors;
  const NodeField field = to_field(array.cast<DoubleArray>(), name);
  for (Index k = 0; k < static_cast<Index>(field.size() / 3); ++k) vectors.push_back(at(field, k));
  return vectors;
}

/// Runs `work` without the interpreter lock.
template <class Work>
auto released(Work&& work) {
  const py::gil_scoped_release release;
  return work();
}

/// True when a signal (Ctrl-C) has arrived; its exception is cleared, the caller reports the interruption.
bool interrupted();

}  // namespace glossa::python

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <memory>

#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"
#include "contact/distance_field.hpp"

namespace glossa::python {
namespace {

using Corner = std::array<double, 3>;

WallSurface to_surface(const DoubleArray& vertices, const IntArray& triangles) {
  const NodeField coordinates = to_field(vertices, "vertices");
  require(triangles.ndim() == 2 && triangles.shape(1) == 3, "triangles: shape must be (m, 3)");
  WallSurface surface;
  for (Index v = 0; v < static_cast<Index>(vertices.shape(0)); ++v) surface.vertices.push_back(at(coordinates, v));
  for (const Index* t = triangles.data(); t != triangles.data() + triangles.size(); t += 3)
    surface.triangles.push_back({t[0], t[1], t[2]});
  return surface;
}

template <class T>
py::array_t<T> copied(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

std::shared_ptr<DistanceField> make_field(const DoubleArray& vertices, const IntArray& triangles, const Corner& low,
                                          const Corner& high, double spacing, double band, int threads) {
  const WallSurface surface = to_surface(vertices, triangles);
  const DistanceFieldOptions options{spacing, band, Vector3(low.data()), Vector3(high.data()), threads};
  return released([&] { return std::make_shared<DistanceField>(surface, options); });
}

py::array_t<double> distance(const DistanceField& field, const DoubleArray& points) {
  const NodeField x = to_field(points, "points");
  return to_array(released([&] {
    std::vector<double> result(x.size() / 3);
    for (std::size_t k = 0; k < result.size(); ++k) result[k] = field.distance(at(x, static_cast<Index>(k)));
    return result;
  }));
}

py::tuple evaluate(const DistanceField& field, const DoubleArray& points) {
  const NodeField x = to_field(points, "points");
  const std::size_t count = x.size() / 3;
  std::vector<double> value(count), gradient(3 * count), hessian(9 * count);
  released([&] {
    for (std::size_t k = 0; k < count; ++k) {
      Vector3 slope;
      Matrix3 curvature;
      value[k] = field.value(at(x, static_cast<Index>(k)), slope, curvature);
      std::copy_n(slope.data(), 3, gradient.data() + 3 * k);
      std::copy_n(curvature.data(), 9, hessian.data() + 9 * k);
    }
    return 0;
  });
  return py::make_tuple(
      to_array(std::move(value)), to_array(std::move(gradient), 3),
      to_array(std::move(hessian)).reshape({static_cast<py::ssize_t>(count), py::ssize_t{3}, py::ssize_t{3}}));
}

py::tuple nearest_features(const DoubleArray& vertices, const IntArray& triangles, const DoubleArray& points) {
  const WallSurface surface = to_surface(vertices, triangles);
  const NodeField x = to_field(points, "points");
  std::vector<double> distances;
  std::vector<Index> nearest, loops;
  std::vector<std::uint8_t> kinds;
  released([&] {
    const NearestFeature wall(surface);
    for (std::size_t k = 0; k < x.size() / 3; ++k) {
      const Nearest found = wall(at(x, static_cast<Index>(k)));
      distances.push_back(found.distance);
      nearest.push_back(found.triangle);
      kinds.push_back(static_cast<std::uint8_t>(found.kind));
      loops.push_back(found.rim_loop);
    }
    return 0;
  });
  return py::make_tuple(to_array(std::move(distances)), copied(nearest), copied(kinds), copied(loops));
}

py::list loops_of(const DoubleArray& vertices, const IntArray& triangles) {
  const WallTopology wall = wall_topology(to_surface(vertices, triangles));
  py::list result;
  for (const RimLoop& loop : rim_loops(wall).loops) {
    std::vector<Vector3> points;
    for (const Index v : loop.vertices) points.push_back(wall.vertices[static_cast<std::size_t>(v)]);
    result.append(py::make_tuple(to_array(flat(points), 3), loop.sheet, loop.outer));
  }
  return result;
}

}  // namespace

void bind_contact(py::module_& module) {
  const DistanceFieldOptions defaults;
  py::class_<DistanceField, std::shared_ptr<DistanceField>>(
      module, "DistanceField",
      "Smooth signed distance of a wall, m: positive on the tongue's side. Immutable. It is told up to the band only: "
      "any point farther from the wall reads band, any deeper in it -band, both without slope and without warning; a "
      "point outside the box from low to high reads band wherever it is.")
      .def(py::init(&make_field), py::arg("vertices"), py::arg("triangles"), py::kw_only(), py::arg("low"),
           py::arg("high"), py::arg("spacing") = defaults.spacing, py::arg("band") = defaults.band,
           py::arg("threads") = defaults.threads)
      .def("distance", &distance, py::arg("points"), "Distance (k,) of points (k, 3), m.")
      .def("evaluate", &evaluate, py::arg("points"),
           "Distance (k,) m, gradient (k, 3) and Hessian (k, 3, 3) 1/m at points (k, 3), m.")
      .def_property_readonly("spacing", &DistanceField::spacing, "Of the lattice of splines, m.")
      .def_property_readonly("band", &DistanceField::band, "Largest distance told, m.")
      .def_property_readonly("geometric_error", &DistanceField::geometric_error,
                             "95 % of the wall's area in the box, 2 mm and more away from rims and edges of more than "
                             "30 degrees, is within this of distance 0, m.")
      .def_property_readonly("edge_rounding", &DistanceField::edge_rounding,
                             "The same of the wall nearer to rims and such edges, m.");
  module.def("nearest_features", &nearest_features, py::arg("vertices"), py::arg("triangles"), py::arg("points"),
             "Exactly nearest place of a wall to each point (k, 3) m: distances (k,) m, negative behind the wall; "
             "triangles (k,); kinds (k,), 0 interior, 1 rim, 2 edge of inconsistent faces; loops (k,), index into "
             "rim_loops, -1 off the rim.");
  module.def("rim_loops", &loops_of, py::arg("vertices"), py::arg("triangles"),
             "Rims of a wall, each (points (k, 3) m in order, number of its connected piece, whether it is the longest "
             "rim of that piece).");
}

}  // namespace glossa::python

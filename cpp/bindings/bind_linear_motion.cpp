#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"
#include "scene/linear_motion.hpp"
#include "scene/solver.hpp"

namespace glossa::python {
namespace {

std::unique_ptr<LinearMotion> linearised(Solver& solver, const DoubleArray& fractions, const DoubleArray& positions,
                                         const py::object& contact_pressure, const py::object& contact_drag,
                                         const py::object& wall_shift) {
  const std::vector<double> command = to_vector(fractions);
  RestState rest;
  rest.positions = to_field(positions, "positions", solver.scene().mesh().node_count());
  if (!contact_pressure.is_none()) rest.contact_pressure = to_vector(contact_pressure.cast<DoubleArray>());
  rest.contact_drag = to_vectors(contact_drag, "contact drag");
  rest.wall_shift = to_vectors(wall_shift, "wall displacements");
  return std::make_unique<LinearMotion>(solver.scene(), commanded_muscles(command), command, std::move(rest));
}

py::array_t<Index> indices(const std::vector<Index>& list) {
  return py::array_t<Index>(static_cast<py::ssize_t>(list.size()), list.data());
}

py::tuple matrix(LinearMotion& motion, double rate, double acceleration) {
  require(std::isfinite(rate) && std::isfinite(acceleration), "matrix: rate and acceleration must be finite");
  const LowerColumns& columns = released([&]() -> const LowerColumns& { return motion.matrix(rate, acceleration); });
  return py::make_tuple(indices(columns.column_start), indices(columns.row), to_array(columns.value));
}

/// Rows of one value per unknown.
py::array_t<double> by_fibre(const LinearMotion& motion, std::vector<double> values) {
  return to_array(std::move(values)).attr("reshape")(motion.active().size(), motion.unknowns().size());
}

Vector unknown_values(const LinearMotion& motion, const DoubleArray& given, const char* name) {
  require(given.ndim() == 1 && given.shape(0) == static_cast<py::ssize_t>(motion.unknowns().size()),
          std::string(name) + ": one value per unknown is needed");
  return Eigen::Map<const Vector>(given.data(), given.shape(0));
}

py::array_t<double> force(LinearMotion& motion, const DoubleArray& displacement, const DoubleArray& velocity,
                          const DoubleArray& activation) {
  require(static_cast<std::size_t>(activation.size()) == motion.active().size(),
          "activation: one value per active fibre is needed");
  const Vector sum = motion.force(unknown_values(motion, displacement, "displacement"),
                                  unknown_values(motion, velocity, "velocity"), to_vector(activation));
  return to_array(std::vector<double>(sum.begin(), sum.end()));
}

}  // namespace

void bind_linear_motion(py::module_& module) {
  py::class_<LinearMotion>(module, "LinearMotion",
                           "Small movements about an equilibrium: M q'' + C q' + K q + sum of pulls times delayed "
                           "activations = 0 (scene/linear_motion.hpp).")
      .def(py::init(&linearised), py::keep_alive<1, 2>(), py::arg("solver"), py::kw_only(), py::arg("fractions"),
           py::arg("positions"), py::arg("contact_pressure") = py::none(), py::arg("contact_drag") = py::none(),
           py::arg("wall_shift") = py::none())
      .def("matrix", &matrix, py::arg("rate"), py::arg("acceleration"),
           "Lower triangle of K + rate C + acceleration M: column starts, rows, values (N/m).")
      .def(
          "pulls", [](LinearMotion& motion) { return by_fibre(motion, motion.pulls()); },
          "Derivative of the forces with respect to the activation of each active fibre, N/m (f, u).")
      .def(
          "gradients", [](LinearMotion& motion) { return by_fibre(motion, motion.gradients()); },
          "Derivative of the length of each active fibre (f, u).")
      .def(
          "spread",
          [](const LinearMotion& motion, const DoubleArray& values) {
            return to_array(motion.spread(unknown_values(motion, values, "values")), 3);
          },
          py::arg("values"), "Node field (n, 3) of one value per unknown, tied nodes to first order.")
      .def("force", &force, py::arg("displacement"), py::arg("velocity"), py::arg("activation"),
           "All forces but that of acceleration, N, at a displacement and a velocity of the unknowns (u,) and "
           "activations (m) of the active fibres.")
      .def_property_readonly("activation", [](const LinearMotion& motion) { return to_array(motion.activation()); })
      .def_property_readonly("active", [](const LinearMotion& motion) { return indices(motion.active()); })
      .def_property_readonly("unknowns", [](const LinearMotion& motion) { return indices(motion.unknowns()); });
}

}  // namespace glossa::python

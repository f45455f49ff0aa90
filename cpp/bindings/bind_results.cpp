#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"
#include "scene/equilibrium.hpp"

namespace glossa::python {
namespace {

py::dict seconds(const Seconds& s) {
  py::dict result;
  for (std::size_t k = 0; k < part_names.size(); ++k) result[part_names[k]] = s.of[k];
  result["total"] = s.total;
  return result;
}

}  // namespace

void bind_results(py::module_& module) {
  py::class_<Report>(module, "Report", "How a solve ended and what it took.")
      .def_property_readonly("status", [](const Report& r) { return status_name(r.status); })
      .def_property_readonly("converged", [](const Report& r) { return r.status == Status::converged; })
      .def_readonly("iterations", &Report::iterations)
      .def_readonly("quasi_newton", &Report::quasi_newton)
      .def_readonly("residuals", &Report::residuals)
      .def_readonly("factorisations", &Report::factorisations)
      .def_readonly("indefinite", &Report::indefinite)
      .def_readonly("line_search", &Report::line_search)
      .def_readonly("steps", &Report::steps)
      .def_readonly("rejected", &Report::rejected)
      .def_readonly("rescued", &Report::rescued)
      .def_readonly("residual", &Report::residual)
      .def_readonly("force_scale", &Report::force_scale)
      .def_readonly("least_jacobian", &Report::least_jacobian)
      .def_readonly("worst_element", &Report::worst_element)
      .def_readonly("error_estimate", &Report::error_estimate)
      .def_readonly("accumulated_error", &Report::accumulated_error)
      .def_readonly("contact_updates", &Report::contact_updates)
      .def_readonly("penetration", &Report::penetration)
      .def_readonly("contact_violation", &Report::contact_violation)
      .def_readonly("residuals_by_iteration", &Report::residuals_by_iteration)
      .def_property_readonly("seconds", [](const Report& r) { return seconds(r.seconds); });

  py::class_<Equilibrium>(module, "Equilibrium", "Static state found by Solver.equilibrate.")
      .def_readonly("report", &Equilibrium::report)
      .def_property_readonly("positions", [](const Equilibrium& q) { return to_array(q.positions, 3); })
      .def_property_readonly("force", [](const Equilibrium& q) { return to_array(q.force, 3); })
      .def_property_readonly("pressure", [](const Equilibrium& q) { return to_array(q.pressure); })
      .def_property_readonly("stiffening", [](const Equilibrium& q) { return to_array(q.stiffening); })
      .def_property_readonly("activation", [](const Equilibrium& q) { return to_array(q.activation); })
      .def_property_readonly("tension", [](const Equilibrium& q) { return to_array(q.tension); })
      .def_property_readonly("contact_pressure", [](const Equilibrium& q) { return to_array(q.contact_pressure); })
      .def_property_readonly("contact_drag", [](const Equilibrium& q) { return to_array(flat(q.contact_drag), 3); });
}

}  // namespace glossa::python

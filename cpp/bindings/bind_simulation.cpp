#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"
#include "scene/simulation.hpp"
#include "scene/solver.hpp"

namespace glossa::python {
namespace {

Integrator integrator(const std::string& name) {
  if (name == "SDIRK2") return Integrator::sdirk2;
  if (name == "BDF2") return Integrator::bdf2;
  if (name == "backward_euler") return Integrator::backward_euler;
  require(name == "trapezoidal",
          "integrator must be 'SDIRK2', 'BDF2', 'backward_euler' or 'trapezoidal', it is '" + name + "'");
  return Integrator::trapezoidal;
}

std::unique_ptr<Simulation> start(Solver& solver, const DoubleArray& times, const DoubleArray& fractions,
                                  const DoubleArray& positions, const py::object& pressure,
                                  const py::object& contact_pressure, const py::object& contact_drag,
                                  const py::object& wall_shift, double time, double max_step, double error_tolerance,
                                  double least_step, double tolerance, const std::string& method) {
  const auto nodes = static_cast<py::ssize_t>(solver.scene().mesh().node_count());
  CommandTable commands(to_vector(times), to_vector(fractions), solver.scene().options().muscle_count);
  SimulationOptions options;
  options.integrator = integrator(method);
  options.max_step = max_step;
  options.error_tolerance = error_tolerance;
  options.least_step = least_step;
  options.tolerance = tolerance;
  options.wall_shift = to_vectors(wall_shift, "wall displacements");
  options.interrupt = interrupted;
  std::vector<double> p;
  if (!pressure.is_none()) p = to_vector(pressure.cast<DoubleArray>());
  require(p.empty() || p.size() == static_cast<std::size_t>(solver.scene().mesh().element_count()),
          "pressure: one value per hexahedron is needed");
  std::vector<double> contact;
  if (!contact_pressure.is_none()) contact = to_vector(contact_pressure.cast<DoubleArray>());
  std::shared_ptr<System> system = solver.system(solver.scene().options().free, commands.commanded());
  return std::make_unique<Simulation>(std::move(system), std::move(commands), options,
                                      to_field(positions, "start", nodes), p, contact,
                                      to_vectors(contact_drag, "contact drag"), time);
}

py::array_t<double> frames(std::vector<double> values, std::size_t count, std::size_t columns) {
  return to_array(std::move(values)).attr("reshape")(count, columns);
}

py::array_t<double> vector_frames(std::vector<double> values, std::size_t count, std::size_t points) {
  return to_array(std::move(values)).attr("reshape")(count, points, 3);
}

py::tuple run(Simulation& simulation, double until) {
  Recording recording;
  const Status status = released([&] { return simulation.advance(until, &recording); });
  const std::size_t count = recording.times.size();
  const auto fibres = static_cast<std::size_t>(simulation.system().scene().options().fibres.count());
  const std::size_t nodes = simulation.state().positions.size() / 3;
  const std::size_t touching = simulation.state().contact_pressure.size();
  return py::make_tuple(status_name(status), to_array(recording.times),
                        vector_frames(recording.positions, count, nodes),
                        vector_frames(recording.velocities, count, nodes), frames(recording.activation, count, fibres),
                        frames(recording.tension, count, fibres), frames(recording.contact_pressure, count, touching),
                        vector_frames(recording.contact_drag, count, touching));
}

std::vector<double> on_scene(const Simulation& simulation, const std::vector<double>& values) {
  auto& system = const_cast<Simulation&>(simulation).system();
  std::vector<double> all(static_cast<std::size_t>(system.scene().options().fibres.count()), 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) all[static_cast<std::size_t>(system.fibre_of()[k])] = values[k];
  return all;
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::class_<State>(module, "State", "Everything that the future of a movement depends on; a value.")
      .def_readonly("time", &State::time);

  py::class_<Simulation>(module, "Simulation", "A movement that is advanced step by step. See glossa.Simulation.")
      .def(py::init(&start), py::keep_alive<1, 2>(), py::arg("solver"), py::kw_only(), py::arg("times"),
           py::arg("fractions"), py::arg("positions"), py::arg("pressure") = py::none(),
           py::arg("contact_pressure") = py::none(), py::arg("contact_drag") = py::none(),
           py::arg("wall_shift") = py::none(), py::arg("time") = 0.0, py::arg("max_step") = 2e-3,
           py::arg("error_tolerance") = 0.0, py::arg("least_step") = 1e-5, py::arg("tolerance") = 2e-6,
           py::arg("integrator") = "SDIRK2")
      .def(
          "step",
          [](Simulation& s, double dt) {
            require(std::isfinite(dt) && dt > 0.0,
                    "time step must be positive and finite, it is " + std::to_string(dt) + " s");
            return status_name(released([&] { return s.advance(s.state().time + dt, nullptr); }));
          },
          py::arg("dt"), "Advances by dt seconds; returns the status name.")
      .def("solve", &run, py::arg("until"),
           "Advances to a time and records every accepted step: status, times, positions, velocities, activations, "
           "tensions, contact pressures, contact drags.")
      .def_property_readonly("time", [](const Simulation& s) { return s.state().time; })
      .def_property_readonly("positions", [](const Simulation& s) { return to_array(s.state().positions, 3); })
      .def_property_readonly("velocities", [](const Simulation& s) { return to_array(s.state().velocities, 3); })
      .def_property_readonly("momentum", [](const Simulation& s) { return to_array(s.state().momentum, 3); })
      .def_property_readonly("activation",
                             [](const Simulation& s) { return to_array(on_scene(s, s.state().activation)); })
      .def_property_readonly("tension", [](const Simulation& s) { return to_array(on_scene(s, s.state().tension)); })
      .def_property_readonly("contact_pressure",
                             [](const Simulation& s) { return to_array(s.state().contact_pressure); })
      .def_property_readonly("contact_drag",
                             [](const Simulation& s) { return to_array(flat(s.state().contact_drag), 3); })
      .def_property(
          "state", [](const Simulation& s) { return s.state(); }, &Simulation::set_state,
          "A copy of the state; assigning one goes back to it.")
      .def_property_readonly("kinetic_energy", &Simulation::kinetic_energy)
      .def_property_readonly("potential_energy", &Simulation::potential_energy)
      .def_property_readonly("report", [](const Simulation& s) { return s.report(); });
}

}  // namespace glossa::python

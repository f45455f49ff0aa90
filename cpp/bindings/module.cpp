// The extension module glossa._core.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arrays.hpp"
#include "bindings/bind_scene.hpp"

namespace glossa::python {

bool interrupted() {
  const py::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() == 0) return false;
  PyErr_Clear();  // the Python layer raises SolveInterrupted, with the last good state
  return true;
}

}  // namespace glossa::python

PYBIND11_MODULE(_core, module) {
  module.doc() = "C++ core of glossa: hexahedra, macrofibres, equilibrium and movement.";
  module.attr("__version__") = GLOSSA_VERSION;
  // glossa.InputError derives from ValueError; the Python layer owns the class, so that both sides raise the same one.
  pybind11::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const glossa::InputError& error) {
      const auto errors = pybind11::module_::import("glossa.errors");
      pybind11::set_error(errors.attr("InputError"), error.what());
    }
  });
  glossa::python::bind_contact(module);
  glossa::python::bind_linear_motion(module);
  glossa::python::bind_results(module);
  glossa::python::bind_scene(module);
  glossa::python::bind_simulation(module);
  glossa::python::bind_system(module);
}

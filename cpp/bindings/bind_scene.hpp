// Scene, equilibrate, step and solve for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace glossa::python {

void bind_scene(pybind11::module_& module);
void bind_results(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);

}  // namespace glossa::python

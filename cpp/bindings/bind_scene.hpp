// Scene, equilibrate, step and solve for Python.
#pragma once

#include <pybind11/pybind11.h>

#include <vector>

namespace glossa::python {

void bind_contact(pybind11::module_& module);
void bind_linear_motion(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_results(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_system(pybind11::module_& module);

/// One flag per muscle from fractions of rest length (NaN: silent); InputError for anything else not positive.
std::vector<bool> commanded_muscles(const std::vector<double>& fractions);

}  // namespace glossa::python

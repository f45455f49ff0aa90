// Activation stiffens muscle tissue: eq. 1 of Buchaillard, Perrier & Payan 2009,
//   s_e = 1 + Sum_m p1(m) Sum_(f in m) A(f) p2(f, e)
//
// The paper sets p1 so that the stiffness stays within bounds "when maximal muscle activation is reached", so A counts
// up to the activation at which the force saturates (ln 2 / c) and no further.
#pragma once

#include "muscle/force_law.hpp"
#include "muscle/macrofibre.hpp"

namespace glossa {

/// s_e for every element from the activations (m) of all fibres; `factors` must have at least the elements touched and
/// is set to 1 where no active fibre runs.
void stiffening_factors(const Macrofibres& fibres, const std::vector<double>& activation, const ForceLaw& law,
                        std::vector<double>& factors);

}  // namespace glossa

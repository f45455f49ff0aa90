// The stretch reflex: eq. 2 of Buchaillard, Perrier & Payan 2009,
//   A(t) = [ l(t - d) - lambda(t) + mu l'(t - d) ]+
#pragma once

#include <algorithm>

namespace glossa {

struct Reflex {
  double delay = 0.017;         ///< d, s (II.C.1, after Ito et al. 2004); 0: no delay
  double velocity_gain = 0.01;  ///< mu, s

  /// Activation (m) from the delayed length (m), the motor command (m) and the delayed rate (m/s).
  [[nodiscard]] double activation(double length, double lambda, double rate) const {
    return std::max(0.0, length - lambda + velocity_gain * rate);
  }
};

}  // namespace glossa

// How a solve ended and what it took.
#pragma once

#include <functional>
#include <string>

#include "core/stopwatch.hpp"
#include "core/types.hpp"

namespace glossa {

enum class Status {
  converged,        ///< residual within tolerance
  iteration_limit,  ///< the allowed iterations were used up
  stalled,          ///< no step along the search direction reduced the energy, or no time step was short enough
  inverted,         ///< the start is inverted, or every step would invert a hexahedron
  penetrated,       ///< the start lies deep behind a wall, or every step would end there
  indefinite,       ///< the tangent could not be made positive definite
  interrupted,      ///< stopped from outside (Ctrl-C)
};

[[nodiscard]] constexpr const char* status_name(Status status) {
  switch (status) {
    case Status::converged:
      return "converged";
    case Status::iteration_limit:
      return "iteration_limit";
    case Status::stalled:
      return "stalled";
    case Status::inverted:
      return "inverted";
    case Status::penetrated:
      return "penetrated";
    case Status::indefinite:
      return "indefinite";
    case Status::interrupted:
      return "interrupted";
  }
  return "unknown";
}

/// Evidence that comes with every result.
struct Report {
  Status status = Status::iteration_limit;
  int iterations = 0;    ///< Newton iterations (statics) or stage solves (dynamics)
  int quasi_newton = 0;  ///< residual + solve pairs with a frozen factor
  int residuals = 0;     ///< residual evaluations
  int factorisations = 0;
  int indefinite = 0;              ///< tangents that needed a cure
  int line_search = 0;             ///< steps cut back
  int steps = 0;                   ///< accepted time steps
  int rejected = 0;                ///< time steps shortened for accuracy or, adaptive ones, slow convergence
  int rescued = 0;                 ///< time steps that needed a fresh factor, a shorter step or backward Euler
  double residual = 0.0;           ///< N, 2-norm over the free components
  double force_scale = 0.0;        ///< N, to which the tolerance refers
  double least_jacobian = 1.0;     ///< smallest J at any Gauss point of the result
  Index worst_element = -1;        ///< where that is
  int contact_updates = 0;         ///< updates of the multipliers of contact
  double penetration = 0.0;        ///< m, deepest penetration of a wall (statics: of the result; dynamics: at any step)
  double contact_violation = 0.0;  ///< m, largest distance from the laws of contact and friction, likewise
  double error_estimate = 0.0;     ///< m, largest estimated local error of the accepted time steps
  double accumulated_error = 0.0;  ///< m, largest estimated error in time of the movement, from those of its steps
  std::vector<double> residuals_by_iteration;
  Seconds seconds;
};

/// Asked every few iterations; true stops the solve.
using Interrupt = std::function<bool()>;

}  // namespace glossa

// Movements for the tests.
#pragma once

#include "bodies.hpp"

namespace glossa::test {

/// A movement from rest.
inline Simulation started(Solver& solver, const CommandTable& commands, const SimulationOptions& options = {}) {
  return {solver.system(solver.scene().options().free, commands.commanded()),
          commands,
          options,
          solver.scene().mesh().nodes(),
          {},
          {},
          {},
          0.0};
}

inline SimulationOptions accurate(double step, Integrator integrator = Integrator::sdirk2) {
  SimulationOptions options;
  options.integrator = integrator;
  options.max_step = step;
  options.tolerance = 1e-11;
  return options;
}

/// Every number of a state, what its history still answers included.
inline std::vector<double> content(const State& s) {
  std::vector<double> all{s.time, s.last_step};
  for (const auto* field : {&s.positions, &s.velocities, &s.momentum, &s.momentum_rate, &s.pressure, &s.stiffening,
                            &s.activation, &s.tension, &s.last_positions, &s.last_velocities, &s.last_momentum,
                            &s.last_stiffening, &s.contact.advance, &s.contact.pressure, &s.contact_pressure})
    all.insert(all.end(), field->begin(), field->end());
  for (const auto* field : {&s.contact.friction, &s.contact.normal, &s.contact.slip_from, &s.contact_drag})
    for (const Vector3& v : *field) all.insert(all.end(), v.data(), v.data() + 3);
  if (s.activation.empty()) return all;
  for (double back = 0.0; back < 0.02; back += 0.7e-3) {
    std::vector<double> lengths, rates;
    s.history.evaluate(s.time - back, lengths, rates);
    all.insert(all.end(), lengths.begin(), lengths.end());
    all.insert(all.end(), rates.begin(), rates.end());
  }
  all.push_back(static_cast<double>(s.history.size()));
  return all;
}

}  // namespace glossa::test

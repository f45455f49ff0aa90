// Which steps are taken; what one step is lies in time_step.cpp.
#include "scene/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "muscle/stiffening.hpp"

namespace glossa {
namespace {

constexpr double smallest_part = 1.0 / 64.0;  // of a step, before it is given up
constexpr double hopeless_share = 0.3;        // of the extent of the body: an increment beyond ends an iteration
constexpr int echoes = 2;                     // how often a corner of the commands is honoured again after one delay

// Times closer than this (s) are one: sums of steps differ from corners of the commands by rounding.
double same_time(double time) {
  return 1e-9 * (1.0 + std::abs(time));
}

}  // namespace

Simulation::Simulation(std::shared_ptr<System> system, CommandTable commands, SimulationOptions options,
                       const NodeField& positions, const std::vector<double>& pressure,
                       const std::vector<double>& contact_pressure, const std::vector<Vector3>& contact_drag,
                       double time)
    : shared_(std::move(system)), system_(*shared_), commands_(std::move(commands)), options_(options) {
  require(std::isfinite(options_.max_step) && options_.max_step > 0.0,
          "time step must be positive and finite, it is " + std::to_string(options_.max_step) + " s");
  require(std::isfinite(options_.error_tolerance) && options_.error_tolerance >= 0.0,
          "error tolerance must be finite and not negative");
  require(std::isfinite(options_.least_step) && options_.least_step > 0.0, "least step must be positive and finite");
  require(std::isfinite(options_.tolerance) && options_.tolerance > 0.0, "tolerance must be positive and finite");
  require(std::isfinite(time), "start time must be finite");
  for (const double corner : commands_.corners())
    for (int echo = 0; echo <= (delayed() ? echoes : 0); ++echo)
      breakpoints_.push_back(corner + (echo > 0 ? echo * system_.scene().options().reflex->delay : 0.0));
  std::sort(breakpoints_.begin(), breakpoints_.end());
  largest_increment_ = hopeless_share * system_.scene().mesh().extent();
  require(positions.size() == system_.scene().mesh().nodes().size() &&
              pressure.size() <= system_.elasticity().padded_count(),
          "start: positions and pressures must fit the body");
  state_.time = time;
  state_.positions = positions;
  state_.velocities.assign(positions.size(), 0.0);
  state_.pressure.assign(system_.elasticity().padded_count(), 0.0);
  std::copy(pressure.begin(), pressure.end(), state_.pressure.begin());

  Trial trial = system_.rest_trial();
  trial.positions = positions;
  system_.set_command(commands_.at(time, true));
  system_.place_tied(trial.positions);
  state_.positions = trial.positions;
  system_.measure(trial);
  if (const MuscleForce* muscles = system_.muscles()) {
    state_.history = DelayHistory(time, muscles->lengths());
    if (delayed()) given_activation(time, true, trial.activation);
  }
  state_.stiffening = stiffening_of(trial.activation);
  state_.activation = trial.activation;
  trial.isochoric_scale = state_.stiffening;
  if (WallContact* contact = system_.contact()) {
    contact->clear();
    const std::size_t walls = system_.scene().options().contact->walls.size();
    require(options_.wall_shift.empty() || options_.wall_shift.size() == walls,
            "start: one displacement per wall is needed");
    options_.wall_shift.resize(walls, Vector3::Zero());
    state_.contact = contact->state();
    const std::size_t points = state_.contact.advance.size();
    require((contact_pressure.empty() || contact_pressure.size() == points) &&
                (contact_drag.empty() || contact_drag.size() == points),
            "start: one pressure and one drag per contact point are needed");
    if (!state_.contact.pressure.empty() && !contact_pressure.empty() && !contact_drag.empty()) {
      state_.contact.pressure = contact_pressure;
      state_.contact.friction = contact_drag;
    }
    enter_contact(state_.contact);
    contact->begin_increment(state_.positions, options_.wall_shift);
  }
  NodeField force;
  system_.force(trial, force);
  require(system_.elasticity().least_jacobian() > 0.0,
          "start: hexahedron " + std::to_string(system_.elasticity().worst_element()) + " is inverted");
  require(!system_.lost(), "start: the body lies deep behind a wall");
  if (WallContact* contact = system_.contact()) {
    contact->tractions(state_.contact_pressure, state_.contact_drag);
    contact->end_increment();
    state_.contact = contact->state();
  }
  if (pressure.empty()) system_.elasticity().set_pressure(state_.pressure);
  state_.tension = system_.muscles() ? system_.muscles()->tensions() : std::vector<double>{};
  state_.momentum_rate = force;
  for (double& x : state_.momentum_rate) x = -x;
  tissue_force(positions, state_.stiffening, 1.0, state_.momentum);
  for (double& x : state_.momentum) x *= system_.scene().options().damping.in_momentum();
  state_.pressure_rate.assign(state_.pressure.size(), 0.0);
  scale_ = system_.force_scale();
  state_.next_step =
      options_.error_tolerance > 0.0 ? std::min(longest_step(), std::max(1e-3, options_.least_step)) : longest_step();
}

bool Simulation::delayed() const {
  const auto& reflex = system_.scene().options().reflex;
  return reflex && reflex->delay > 0.0 && system_.muscles() != nullptr;
}

double Simulation::longest_step() const {
  // Delayed rates are known up to the midpoint of the last step.
  return delayed() ? std::min(options_.max_step, system_.scene().options().reflex->delay / 1.5) : options_.max_step;
}

double Simulation::next_breakpoint(double until) const {
  const double beyond = state_.time + same_time(state_.time);
  const auto next = std::upper_bound(breakpoints_.begin(), breakpoints_.end(), beyond);
  return next != breakpoints_.end() && *next <= until + same_time(until) ? *next : until;
}

bool Simulation::at_breakpoint() const {
  return std::any_of(breakpoints_.begin(), breakpoints_.end(),
                     [&](double at) { return std::abs(at - state_.time) <= same_time(state_.time); });
}

double Simulation::proposed_step(double until) const {
  const double left = next_breakpoint(until) - state_.time;
  const double wish = std::min(options_.error_tolerance > 0.0 ? state_.next_step : options_.max_step, longest_step());
  const double parts = std::max(1.0, std::ceil(left / wish * (1.0 - 1e-9)));
  return left / parts;
}

Status Simulation::advance(double until, Recording* recording) {
  require(std::isfinite(until) && until - state_.time > same_time(until),
          "simulation: the end must lie after the present time " + std::to_string(state_.time) + " s, it is " +
              std::to_string(until));
  const auto begin = std::chrono::steady_clock::now();
  const Seconds before = system_.seconds();
  report_.status = Status::converged;
  system_.set_load({});
  while (until - state_.time > same_time(until) && report_.status == Status::converged) {
    if (options_.interrupt && options_.interrupt()) {
      report_.status = Status::interrupted;
      break;
    }
    std::optional<State> uncrossed = cross_jump();
    const double whole = proposed_step(until);
    double h = whole, proposal = state_.next_step, shortest_failed = whole;
    bool taken = false;
    while (!taken) {
      State next;
      double defect = 0.0;
      const bool last_resort = shortest_failed <= whole * smallest_part;
      taken = attempt(h, last_resort ? Integrator::backward_euler : options_.integrator, next, defect);
      if (!taken) {
        ++(too_long_ ? report_.rejected : report_.rescued);
        if (last_resort) break;
        h *= 0.5;
        shortest_failed = h;
        continue;
      }
      const double error = defect * defect_share(options_.integrator);
      if (options_.error_tolerance > 0.0) {
        const double ratio = options_.error_tolerance / std::max(error, 1e-3 * options_.error_tolerance);
        const double change = std::clamp(0.85 * std::cbrt(ratio), 0.2, 2.5);
        if (error > 1.5 * options_.error_tolerance && h > options_.least_step) {
          ++report_.rejected;
          taken = false;
          h = std::max(h * std::min(0.9, change), std::min(options_.least_step, whole));
          proposal = h;
          continue;
        }
        if (change < 0.9 || change > 1.25)
          proposal = std::min(std::max(h * change, options_.least_step), longest_step());
      }
      // The last step to a breakpoint lands on it exactly.
      if (h == whole && whole == next_breakpoint(until) - state_.time) next.time = next_breakpoint(until);
      next.next_step = proposal;
      accept(std::move(next), h, error);
      if (recording != nullptr) record(*recording);
    }
    if (!taken) {
      report_.status = Status::stalled;
      if (uncrossed) state_ = std::move(*uncrossed);
      factor_ = state_.factor;
      factor_stamp_ = -1;
    }
  }
  report_.seconds = system_.seconds();
  for (std::size_t k = 0; k < before.of.size(); ++k) report_.seconds.of[k] -= before.of[k];
  report_.seconds.total = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report_.residual = residual_;
  report_.force_scale = scale_;
  return report_.status;
}

void Simulation::accept(State next, double h, double error) {
  next.last_step = h;
  next.factor = factor_;
  // Errors of past steps relax as the tissue does, with beta as time constant.
  const double beta = system_.scene().options().damping.beta;
  next.error = error + (beta > 0.0 ? std::exp(-h / beta) : 1.0) * state_.error;
  next.last_positions = std::move(state_.positions);
  next.last_velocities = std::move(state_.velocities);
  next.last_momentum = std::move(state_.momentum);
  next.last_stiffening = std::move(state_.stiffening);
  next.last_pressure = std::move(state_.pressure);
  next.history = std::move(state_.history);
  if (const MuscleForce* muscles = system_.muscles()) {
    next.history.append(next.time, muscles->lengths());
    if (delayed()) next.history.forget(system_.scene().options().reflex->delay);
  }
  state_ = std::move(next);
  ++report_.steps;
  report_.error_estimate = std::max(report_.error_estimate, error);
  report_.accumulated_error = std::max(report_.accumulated_error, state_.error);
  report_.least_jacobian = std::min(report_.least_jacobian, system_.elasticity().least_jacobian());
  if (const WallContact* contact = system_.contact())
    report_.penetration = std::max(report_.penetration, contact->penetration());
}

// Contact as this movement left it: the system may have served another solve in between.
void Simulation::enter_contact(const ContactState& contact) {
  system_.contact()->set_state(contact);
  system_.contact()->set_shift(options_.wall_shift);
}

void Simulation::set_state(State state) {
  require(state.positions.size() == state_.positions.size() && state.activation.size() == state_.activation.size(),
          "state: it belongs to another scene or other muscles");
  state_ = std::move(state);
  factor_ = state_.factor;
  factor_stamp_ = -1;
}

double Simulation::kinetic_energy() const {
  NodeField momentum(state_.velocities.size(), 0.0);
  system_.inertia().multiply(0.5, state_.velocities, momentum);
  double sum = 0.0;
  for (std::size_t k = 0; k < momentum.size(); ++k) sum += momentum[k] * state_.velocities[k];
  return sum;
}

double Simulation::potential_energy() {
  system_.set_load({});
  if (system_.contact() != nullptr) {
    ContactState frictionless = state_.contact;
    std::fill(frictionless.pressure.begin(), frictionless.pressure.end(), 0.0);
    enter_contact(frictionless);
  }
  Trial trial = system_.rest_trial();
  trial.positions = state_.positions;
  trial.isochoric_scale = state_.stiffening;
  trial.activation_follows = false;
  system_.force(trial, force_);
  return system_.energy(trial);
}

void Simulation::record(Recording& recording) const {
  recording.times.push_back(state_.time);
  recording.positions.insert(recording.positions.end(), state_.positions.begin(), state_.positions.end());
  recording.velocities.insert(recording.velocities.end(), state_.velocities.begin(), state_.velocities.end());
  const auto fibres = static_cast<std::size_t>(system_.scene().options().fibres.count());
  const std::size_t first = recording.activation.size();
  recording.activation.resize(first + fibres, 0.0);
  recording.tension.resize(first + fibres, 0.0);
  for (std::size_t k = 0; k < system_.fibre_of().size(); ++k) {
    recording.activation[first + static_cast<std::size_t>(system_.fibre_of()[k])] = state_.activation[k];
    recording.tension[first + static_cast<std::size_t>(system_.fibre_of()[k])] = state_.tension[k];
  }
  recording.contact_pressure.insert(recording.contact_pressure.end(), state_.contact_pressure.begin(),
                                    state_.contact_pressure.end());
  for (const Vector3& drag : state_.contact_drag)
    recording.contact_drag.insert(recording.contact_drag.end(), drag.data(), drag.data() + 3);
}

void Simulation::given_activation(double time, bool after, std::vector<double>& activation) {
  const Reflex& reflex = *system_.scene().options().reflex;
  const std::vector<double> lambda = system_.lambda(commands_.at(time, after));
  state_.history.evaluate(time - reflex.delay, delayed_lengths_, delayed_rates_);
  activation.resize(lambda.size());
  for (std::size_t k = 0; k < lambda.size(); ++k)
    activation[k] = reflex.activation(delayed_lengths_[k], lambda[k], delayed_rates_[k]);
}

std::vector<double> Simulation::stiffening_of(const std::vector<double>& activation) const {
  std::vector<double> factors(system_.elasticity().padded_count(), 1.0);
  if (system_.scene().options().stiffening)
    stiffening_factors(system_.fibres(), activation, system_.scene().options().force_law, factors);
  return factors;
}

// Where the commands jump, so do the stiffening factors, and w = M v + beta f with them: v does not.
// Returns the state before, if there is a jump.
std::optional<State> Simulation::cross_jump() {
  const std::vector<double> before = commands_.at(state_.time, false), after = commands_.at(state_.time, true);
  const bool jump = !std::equal(before.begin(), before.end(), after.begin(),
                                [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); });
  if (!jump || !system_.muscles() || state_.last_step == 0.0) return std::nullopt;
  State before_jump = state_;
  std::vector<double> activation = state_.activation;
  if (delayed())
    given_activation(state_.time, true, activation);
  else {
    const std::vector<double> old_lambda = system_.lambda(before), new_lambda = system_.lambda(after);
    const auto& reflex = system_.scene().options().reflex;
    for (std::size_t k = 0; k < activation.size(); ++k)
      activation[k] = Reflex{0.0, reflex ? reflex->velocity_gain : 0.0}.activation(
          state_.history.last_lengths()[k], new_lambda[k],
          fibre_rate(system_.fibres(), static_cast<Index>(k), state_.positions, state_.velocities));
  }
  std::vector<double> factors = stiffening_of(activation), change = factors;
  for (std::size_t e = 0; e < change.size(); ++e) change[e] -= state_.stiffening[e];
  NodeField force;
  tissue_force(state_.positions, change, 0.0, force);
  const double beta = system_.scene().options().damping.in_momentum();
  for (std::size_t k = 0; k < force.size(); ++k) state_.momentum[k] += beta * force[k];
  state_.stiffening = std::move(factors);
  state_.activation = std::move(activation);
  state_.last_step = 0.0;
  return before_jump;
}

void Simulation::tissue_force(const NodeField& positions, const std::vector<double>& isochoric, double volumetric,
                              NodeField& force) {
  Trial trial;
  trial.positions = positions;
  trial.isochoric_scale = isochoric;
  trial.elastic_share = volumetric;
  force.assign(positions.size(), 0.0);
  system_.elasticity().add_force(trial, force);
}

}  // namespace glossa

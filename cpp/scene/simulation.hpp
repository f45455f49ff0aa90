// Movement of a scene under motor commands that change with time.
#pragma once

#include <optional>

#include "muscle/delay_history.hpp"
#include "scene/command_table.hpp"
#include "scene/system.hpp"
#include "solver/anderson.hpp"
#include "solver/integrator.hpp"

namespace glossa {

struct SimulationOptions {
  Integrator integrator = Integrator::sdirk2;
  double max_step = 2e-3;           ///< s; the step where `error_tolerance` is 0
  double error_tolerance = 0.0;     ///< m of estimated local error; > 0 lets the step adapt below max_step
  double least_step = 1e-5;         ///< s; an adaptive step is not made shorter for the sake of its error
  double tolerance = 2e-6;          ///< residual of a stage over force scale
  std::vector<Vector3> wall_shift;  ///< m, where each wall stays displaced to
  Interrupt interrupt;
};

/// Where the factor in use was assembled: enough to make the very same one again.
struct FactorPoint {
  double hg;
  double time;
  Trial trial;
  NodeField base_momentum;
  ContactState contact;
};

/// Everything that the future of a movement depends on. A value: copies are independent, and going back to one repeats
/// the movement to the last bit.
struct State {
  double time = 0.0;                  ///< s
  NodeField positions;                ///< m
  NodeField velocities;               ///< m/s
  NodeField momentum;                 ///< w of solver/integrator.hpp, N s
  NodeField momentum_rate;            ///< w' (trapezoidal rule only), N
  std::vector<double> pressure_rate;  ///< Pa/s, padded (trapezoidal rule only)
  std::vector<double> pressure;       ///< Pa, padded
  std::vector<double> stiffening;     ///< s_e, padded
  std::vector<double> activation;     ///< m, per fibre of the system
  std::vector<double> tension;        ///< N
  DelayHistory history;
  double last_step = 0.0;  ///< s; 0 before the first step and after a jump of the commands
  NodeField last_positions, last_velocities, last_momentum;
  double next_step = 0.0;                     ///< s, proposed by the error control
  double error = 0.0;                         ///< m, estimated, of the movement so far
  std::shared_ptr<const FactorPoint> factor;  ///< null: the next stage makes one
  std::vector<double> last_stiffening, last_pressure;
  ContactState contact;
  std::vector<double> contact_pressure;  ///< Pa, of each contact point
  std::vector<Vector3> contact_drag;     ///< Pa, friction of the body on the wall
};

/// One frame per accepted time step.
struct Recording {
  std::vector<double> times;
  std::vector<double> positions, velocities;  ///< frames x nodes x 3
  std::vector<double> activation, tension;    ///< frames x fibres of the scene
  std::vector<double> contact_pressure;       ///< Pa, frames x contact points
  std::vector<double> contact_drag;           ///< Pa, frames x contact points x 3
};

class Simulation {
 public:
  /// Starts at rest at `time` in the given positions; element pressures, contact pressures and drags may be empty.
  Simulation(std::shared_ptr<System> system, CommandTable commands, SimulationOptions options,
             const NodeField& positions, const std::vector<double>& pressure,
             const std::vector<double>& contact_pressure, const std::vector<Vector3>& contact_drag, double time);

  /// Moves on to `time`, in as many steps as the options and the delay ask for. On failure or interruption the state
  /// is that of the last accepted step and the report says why.
  Status advance(double time, Recording* recording);

  [[nodiscard]] const State& state() const { return state_; }
  void set_state(State state);
  [[nodiscard]] const Report& report() const { return report_; }
  [[nodiscard]] System& system() { return system_; }
  [[nodiscard]] double kinetic_energy() const;
  /// Potential energy (J) of tissue, loads, springs and the penalty of contact; without muscles and friction.
  [[nodiscard]] double potential_energy();
  void record(Recording& recording) const;

 private:
  // One implicit equation: u, w and s at `time` from the bases and hg (solver/integrator.hpp).
  struct Stage {
    double hg = 0.0;
    double time = 0.0;
    double offset = 0.0;  // time since the start of the step
    NodeField base_positions, base_momentum;
    std::vector<double> base_pressure;
    std::vector<double> base_stiffening;  // where the activation follows: s' = (s - base) / span
    double span = 0.0;
    std::vector<double> rate;  // s' where the activation is given
  };
  [[nodiscard]] bool delayed() const;
  [[nodiscard]] double longest_step() const;
  [[nodiscard]] double next_breakpoint(double until) const;
  [[nodiscard]] bool at_breakpoint() const;
  [[nodiscard]] double proposed_step(double until) const;

  void given_activation(double time, bool after, std::vector<double>& activation);
  [[nodiscard]] std::vector<double> stiffening_of(const std::vector<double>& activation) const;
  std::optional<State> cross_jump();
  void tissue_force(const NodeField& positions, const std::vector<double>& isochoric, double volumetric,
                    NodeField& force);

  void enter_contact(const ContactState& contact);
  bool attempt(double h, Integrator method, State& next, double& defect);
  [[nodiscard]] Stage first_stage(double h, Integrator method) const;
  [[nodiscard]] Trial stage_trial(const Stage& stage);
  bool solve_stage(const Stage& stage, Trial& trial);
  bool iterate(const Stage& stage, Trial& trial, bool newton);
  void evaluate(const Stage& stage, Trial& trial);
  void search(const Stage& stage, Trial& trial, const Vector& increment, double slope);
  bool renew_factor(const Stage& stage, const Trial& trial);
  bool remake_factor();
  [[nodiscard]] bool valid() const;
  [[nodiscard]] NodeField stage_momentum(const Stage& stage, const Trial& trial);
  void finish(const Stage& stage, const Trial& trial, double h, State& next);
  void accept(State next, double h, double defect);

  std::shared_ptr<System> shared_;
  System& system_;
  CommandTable commands_;
  std::vector<double> breakpoints_;  // s, ascending: corners of the commands and their echoes
  SimulationOptions options_;
  State state_;
  Report report_;
  Anderson anderson_;
  NodeField force_;
  Trial previous_;  // before the last quasi-Newton step
  double residual_ = 0.0;
  double scale_ = 0.0;
  std::shared_ptr<const FactorPoint> factor_;  // in use; null: none
  long factor_stamp_ = -1;                     // of the system when this simulation factorised last
  double largest_increment_ = 0.0;             // m
  bool too_long_ = false;                      // the last attempt failed because an adaptive step was long
  std::vector<double> delayed_lengths_, delayed_rates_;
};

}  // namespace glossa

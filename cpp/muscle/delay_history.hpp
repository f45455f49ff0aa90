// What the reflex remembers: lengths of the macrofibres at the ends of past steps.
//
// Delayed rates are interpolated linearly, between the midpoints of the steps, from the *mean* rates of the steps;
// delayed lengths are cubic Hermite polynomials with slopes from the same means. Interpolating the rates of the stages
// of a Runge-Kutta step instead lets them alternate from step to step and grow (velocity is nearly algebraic in this
// overdamped body, so the loop is close to a neutral delay equation); the mean filters that mode and is second order.
// Before its first time the body is at rest at the first lengths.
#pragma once

#include <deque>
#include <vector>

namespace glossa {

class DelayHistory {
 public:
  DelayHistory() = default;
  /// Starts at `time` (s) with the fibre lengths (m) that held for all times before.
  DelayHistory(double time, std::vector<double> lengths);

  /// The end of an accepted step; `time` must be later than the last one.
  void append(double time, std::vector<double> lengths);
  /// Drops what lies more than `reach` (s) before the last time, beyond what interpolation needs.
  void forget(double reach);

  /// Lengths (m) and rates (m/s) of all fibres at `time`; later than the last midpoint the rate is extrapolated.
  void evaluate(double time, std::vector<double>& lengths, std::vector<double>& rates) const;

  [[nodiscard]] double last_time() const { return knots_.back().time; }
  [[nodiscard]] const std::vector<double>& last_lengths() const { return knots_.back().lengths; }
  [[nodiscard]] std::size_t size() const { return knots_.size(); }

 private:
  struct Knot {
    double time;
    std::vector<double> lengths;
  };
  std::deque<Knot> knots_;
  bool starts_at_rest_ = true;
};

}  // namespace glossa

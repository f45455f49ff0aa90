// Motor commands over time: piecewise linear, with jumps.
#pragma once

#include "core/types.hpp"

namespace glossa {

/// Rows of lambda fractions (one column per muscle; NaN for a muscle that stays silent) at times that do not decrease.
/// Two equal times are a jump: the first row holds just before, the second just after. Constant outside.
class CommandTable {
 public:
  /// Throws InputError for decreasing or non-finite times, more than two equal times, or sizes that do not fit.
  CommandTable(std::vector<double> times, std::vector<double> fractions, Index muscles);

  /// Fractions at `time`, just after it where `after`, just before it otherwise.
  [[nodiscard]] std::vector<double> at(double time, bool after) const;
  /// Times where the slope or the value changes.
  [[nodiscard]] const std::vector<double>& corners() const { return times_; }
  [[nodiscard]] std::vector<bool> commanded() const;

 private:
  std::vector<double> times_;
  std::vector<double> fractions_;
  std::size_t muscles_;
};

}  // namespace glossa

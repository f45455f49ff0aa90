#include "scene/command_table.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace glossa {

CommandTable::CommandTable(std::vector<double> times, std::vector<double> fractions, Index muscles)
    : times_(std::move(times)), fractions_(std::move(fractions)), muscles_(static_cast<std::size_t>(muscles)) {
  require(!times_.empty() && fractions_.size() == times_.size() * muscles_,
          "commands: one row of fractions per time and one column per muscle are needed");
  for (std::size_t k = 0; k < times_.size(); ++k) {
    require(std::isfinite(times_[k]), "commands: times must be finite");
    require(k == 0 || times_[k] >= times_[k - 1], "commands: times must not decrease");
    require(k < 2 || times_[k] > times_[k - 2], "commands: at most two rows may share one time (a jump)");
  }
  for (std::size_t k = 0; k < fractions_.size(); ++k) {
    const bool silent = std::isnan(fractions_[k]);
    require(silent || (std::isfinite(fractions_[k]) && fractions_[k] > 0.0),
            "commands: lambda must be positive (NaN for a silent muscle), it is " + std::to_string(fractions_[k]));
    require(silent == std::isnan(fractions_[k % muscles_]), "commands: a muscle is commanded at all times or never");
  }
}

std::vector<double> CommandTable::at(double time, bool after) const {
  const auto above = after ? std::upper_bound(times_.begin(), times_.end(), time)
                           : std::lower_bound(times_.begin(), times_.end(), time);
  const auto right = static_cast<std::size_t>(above - times_.begin());
  const auto row = [&](std::size_t k) { return fractions_.begin() + static_cast<std::ptrdiff_t>(k * muscles_); };
  std::vector<double> result(muscles_);
  if (right == 0 || right == times_.size()) {
    std::copy_n(row(right == 0 ? 0 : times_.size() - 1), muscles_, result.begin());
    return result;
  }
  const double x = (time - times_[right - 1]) / (times_[right] - times_[right - 1]);
  for (std::size_t m = 0; m < muscles_; ++m)
    result[m] =
        (1.0 - x) * row(right - 1)[static_cast<std::ptrdiff_t>(m)] + x * row(right)[static_cast<std::ptrdiff_t>(m)];
  return result;
}

std::vector<bool> CommandTable::commanded() const {
  std::vector<bool> flags;
  for (std::size_t m = 0; m < muscles_; ++m) flags.push_back(!std::isnan(fractions_[m]));
  return flags;
}

}  // namespace glossa

#include "muscle/delay_history.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"

namespace glossa {

DelayHistory::DelayHistory(double time, std::vector<double> lengths) {
  knots_.push_back({time, std::move(lengths)});
}

void DelayHistory::append(double time, std::vector<double> lengths) {
  require(!knots_.empty() && time > knots_.back().time, "delay history: time must grow, " + std::to_string(time));
  knots_.push_back({time, std::move(lengths)});
}

void DelayHistory::forget(double reach) {
  const double oldest = knots_.back().time - reach;
  // Interpolation at `oldest` looks at the interval that holds it and one more on each side.
  while (knots_.size() > 4 && knots_[3].time < oldest) {
    knots_.pop_front();
    starts_at_rest_ = false;
  }
}

void DelayHistory::evaluate(double time, std::vector<double>& lengths, std::vector<double>& rates) const {
  const std::size_t count = knots_.back().lengths.size();
  lengths.resize(count);
  rates.assign(count, 0.0);
  const auto later =
      std::upper_bound(knots_.begin(), knots_.end(), time, [](double t, const Knot& knot) { return t < knot.time; });
  if (later == knots_.begin() || knots_.size() == 1) {
    lengths = knots_.front().lengths;
    return;
  }
  const std::size_t last = knots_.size() - 1;
  const std::size_t right = std::min<std::size_t>(static_cast<std::size_t>(later - knots_.begin()), last);
  const std::size_t left = right - 1;
  const double h = knots_[right].time - knots_[left].time;
  const double x = (time - knots_[left].time) / h;
  const double h_before = left > 0 ? knots_[left].time - knots_[left - 1].time : 0.0;
  const double h_after = right < last ? knots_[right + 1].time - knots_[right].time : 0.0;

  // Weights of the cubic Hermite polynomial.
  const double p0 = (1 + 2 * x) * (1 - x) * (1 - x), p1 = x * x * (3 - 2 * x);
  const double q0 = h * x * (1 - x) * (1 - x), q1 = h * x * x * (x - 1);
  for (std::size_t f = 0; f < count; ++f) {
    const double a = knots_[left].lengths[f], b = knots_[right].lengths[f];
    const double mean = (b - a) / h;
    const bool first = left == 0;
    const double before = first ? (starts_at_rest_ ? 0.0 : mean) : (a - knots_[left - 1].lengths[f]) / h_before;
    // Rate at the left end: from the two means around it; at the very start the body rests.
    const double start = first ? before : (before * h + mean * h_before) / (h + h_before);
    double after = mean, end;
    if (right < last) {
      after = (knots_[right + 1].lengths[f] - b) / h_after;
      end = (mean * h_after + after * h) / (h + h_after);
    } else {
      end = mean + (first ? mean - start : (mean - before) * h / (h + h_before));
    }
    lengths[f] = p0 * a + p1 * b + q0 * start + q1 * end;
    if (x < 0.5) {
      const double span = first ? 0.5 * h : 0.5 * (h + h_before);
      const double from = first ? 0.0 : 0.5 * h_before;
      rates[f] = before + (mean - before) * (from + x * h) / span;
    } else if (right < last) {
      rates[f] = mean + (after - mean) * (x - 0.5) * h / (0.5 * (h + h_after));
    } else {
      rates[f] = mean + (end - mean) * (x - 0.5) * 2.0;
    }
  }
}

}  // namespace glossa

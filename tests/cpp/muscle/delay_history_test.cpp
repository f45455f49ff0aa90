#include "muscle/delay_history.hpp"

#include "../fixture.hpp"

namespace glossa::test {
namespace {

const std::vector<double> steps{2e-3, 1e-3, 2.5e-3, 0.7e-3, 2e-3, 2e-3, 1.2e-3, 3e-3};

template <class Function>
DelayHistory recorded(Function&& length, double scale = 1.0, int repeats = 1) {
  double time = 0.1;
  DelayHistory history(time, length(time));
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (const double h : steps) {
      time += scale * h;
      history.append(time, length(time));
    }
  return history;
}

struct Values {
  std::vector<double> lengths, rates;
};
Values at_time(const DelayHistory& history, double time) {
  Values v;
  history.evaluate(time, v.lengths, v.rates);
  return v;
}

}  // namespace

TEST_CASE("delay history: rest before the first time") {
  const DelayHistory history = recorded([](double t) { return std::vector{0.05 + t, 0.03}; });
  for (const double t : {-1.0, 0.0999}) {
    CHECK(at_time(history, t).lengths == std::vector{0.05 + 0.1, 0.03});
    CHECK(at_time(history, t).rates == std::vector{0.0, 0.0});
  }
  const DelayHistory alone(0.0, {0.05});
  CHECK(at_time(alone, 3.0).lengths == std::vector{0.05});
  CHECK(at_time(alone, 3.0).rates == std::vector{0.0});
}

TEST_CASE("delay history: a quadratic that starts at rest is exact at all times, lengths and rates") {
  const auto length = [](double t) { return std::vector{0.05 + 300.0 * (t - 0.1) * (t - 0.1)}; };
  const DelayHistory history = recorded(length);
  for (double t = 0.1; t < history.last_time() + 1e-3; t += 0.13e-3) {
    CHECK_WITHIN(std::abs(at_time(history, t).lengths[0] - length(t)[0]), 1e-15);
    CHECK_WITHIN(std::abs(at_time(history, t).rates[0] - 600.0 * (t - 0.1)), 2e-13);  // rounding over the step
  }
}

TEST_CASE("delay history: a general quadratic is exact after the first step, with its rate as the midpoint's mean") {
  const auto length = [](double t) {
    return std::vector{0.05 + 2.0 * (t - 0.1) - 300.0 * (t - 0.1) * (t - 0.1), 0.02};
  };
  const DelayHistory history = recorded(length);
  for (double t = 0.102; t < history.last_time() + 1e-3; t += 0.13e-3) {
    const Values v = at_time(history, t);
    CHECK_WITHIN(std::abs(v.lengths[0] - length(t)[0]), 1e-15);
    CHECK_WITHIN(std::abs(v.lengths[1] - 0.02), 1e-17);
    CHECK(v.rates[1] == 0.0);
    if (t > 0.1025) CHECK_WITHIN(std::abs(v.rates[0] - (2.0 - 600.0 * (t - 0.1))), 2e-13);
  }
}

TEST_CASE("delay history: a rate is the mean of the step at its midpoint, and lengths pass through the knots") {
  Random random(31);
  const DelayHistory history = recorded([&](double) { return std::vector{random(0.04, 0.06)}; });
  Random again(31);
  double left = again(0.04, 0.06), time = 0.1;
  for (const double h : steps) {
    const double right = again(0.04, 0.06);
    CHECK_WITHIN(std::abs(at_time(history, time + 0.5 * h).rates[0] / ((right - left) / h) - 1.0), 1e-13);
    CHECK_WITHIN(std::abs(at_time(history, time).lengths[0] - left), 1e-15);
    time += h;
    left = right;
  }
}

TEST_CASE("delay history: second order for smooth lengths and uneven steps") {
  const auto length = [](double t) { return std::vector{0.05 + 0.01 * std::sin(80.0 * (t - 0.1)) * (t - 0.1) / 0.02}; };
  const auto rate = [&](double t) { return slope([&](double h) { return length(t + h)[0]; }, 1e-5); };
  const auto errors = [&](double scale, int repeats) {
    const DelayHistory history = recorded(length, scale, repeats);
    Values worst{{0.0}, {0.0}};
    for (double t = 0.105; t < 0.114; t += 0.07e-3) {
      worst.lengths[0] = std::max(worst.lengths[0], std::abs(at_time(history, t).lengths[0] - length(t)[0]));
      worst.rates[0] = std::max(worst.rates[0], std::abs(at_time(history, t).rates[0] - rate(t)));
    }
    return worst;
  };
  const Values coarse = errors(0.125, 8), fine = errors(0.03125, 32);
  CHECK(std::log2(coarse.rates[0] / fine.rates[0]) / 2.0 > 1.9);
  CHECK(std::log2(coarse.lengths[0] / fine.lengths[0]) / 2.0 > 2.9);
}

TEST_CASE("delay history: forgetting does not change what can still be asked for") {
  const auto length = [](double t) { return std::vector{0.05 + 0.01 * std::sin(80.0 * t), t}; };
  const double reach = 4e-3;
  const DelayHistory whole = recorded(length, 1.0, 3);
  DelayHistory pruned(0.1, length(0.1));
  double time = 0.1;
  for (int repeat = 0; repeat < 3; ++repeat)
    for (const double h : steps) {
      time += h;
      pruned.append(time, length(time));
      pruned.forget(reach);
    }
  REQUIRE(pruned.size() < whole.size() / 2);
  for (double t = whole.last_time() - reach; t < whole.last_time() + 2e-3; t += 0.11e-3) {
    CHECK(at_time(pruned, t).lengths == at_time(whole, t).lengths);
    CHECK(at_time(pruned, t).rates == at_time(whole, t).rates);
  }
}

TEST_CASE("delay history: time must grow") {
  DelayHistory history(0.1, {0.05});
  CHECK_THROWS_WITH_AS(history.append(0.1, {0.05}), "delay history: time must grow, 0.100000", InputError);
  CHECK_THROWS_AS(history.append(0.05, {0.05}), InputError);
  CHECK_THROWS_AS(DelayHistory().append(0.05, {0.05}), InputError);
  CHECK(history.size() == 1);
}

}  // namespace glossa::test

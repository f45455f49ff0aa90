#include "scene/command_table.hpp"

#include <limits>

#include "../fixture.hpp"

namespace glossa::test {
namespace {

constexpr double silent = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("command table: linear between rows, constant outside") {
  const CommandTable table({0.1, 0.2}, {1.0, 0.8, 0.6, 0.9}, 2);
  CHECK(table.at(0.0, true) == std::vector{1.0, 0.8});
  CHECK(table.at(0.1, false) == std::vector{1.0, 0.8});
  CHECK(table.at(0.125, true)[0] == doctest::Approx(0.9).epsilon(1e-15));
  CHECK(table.at(0.125, false)[1] == doctest::Approx(0.825).epsilon(1e-15));
  CHECK(table.at(0.2, true) == std::vector{0.6, 0.9});
  CHECK(table.at(7.0, false) == std::vector{0.6, 0.9});
  CHECK(table.corners() == std::vector{0.1, 0.2});
}

TEST_CASE("command table: a jump has a value before and one after") {
  const CommandTable table({0.0, 0.1, 0.1, 0.2}, {1.0, 0.9, 0.5, 0.7}, 1);
  CHECK(table.at(0.1, false)[0] == doctest::Approx(0.9).epsilon(1e-15));
  CHECK(table.at(0.1, true) == std::vector{0.5});
  CHECK(table.at(0.05, true)[0] == doctest::Approx(0.95));
  CHECK(table.at(0.15, true)[0] == doctest::Approx(0.6));
  const CommandTable at_once({0.0, 0.0}, {1.0, 0.5}, 1);
  CHECK(at_once.at(0.0, false) == std::vector{1.0});
  CHECK(at_once.at(0.0, true) == std::vector{0.5});
}

TEST_CASE("command table: muscles that stay silent") {
  const CommandTable table({0.0, 0.1}, {silent, 1.0, silent, 0.5}, 2);
  CHECK(table.commanded() == std::vector{false, true});
  CHECK(std::isnan(table.at(0.05, true)[0]));
  CHECK(table.at(0.05, true)[1] == doctest::Approx(0.75));
}

TEST_CASE("command table: refusals") {
  const auto refused = [](std::vector<double> times, std::vector<double> fractions, const char* message) {
    CHECK_THROWS_WITH_AS(CommandTable(times, fractions, 1), message, InputError);
  };
  const double infinite = std::numeric_limits<double>::infinity();
  refused({}, {}, "commands: one row of fractions per time and one column per muscle are needed");
  refused({0.0, 0.1}, {1.0}, "commands: one row of fractions per time and one column per muscle are needed");
  refused({0.0, infinite}, {1.0, 1.0}, "commands: times must be finite");
  refused({0.0, silent}, {1.0, 1.0}, "commands: times must be finite");
  refused({0.1, 0.0}, {1.0, 1.0}, "commands: times must not decrease");
  refused({0.1, 0.1, 0.1}, {1.0, 1.0, 1.0}, "commands: at most two rows may share one time (a jump)");
  refused({0.0}, {-0.5}, "commands: lambda must be positive (NaN for a silent muscle), it is -0.500000");
  refused({0.0}, {0.0}, "commands: lambda must be positive (NaN for a silent muscle), it is 0.000000");
  refused({0.0}, {infinite}, "commands: lambda must be positive (NaN for a silent muscle), it is inf");
  refused({0.0, 0.1}, {1.0, silent}, "commands: a muscle is commanded at all times or never");
}

}  // namespace glossa::test

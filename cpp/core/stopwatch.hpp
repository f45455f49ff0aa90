// Where the seconds of a solve went.
#pragma once

#include <array>
#include <chrono>

namespace glossa {

/// Parts of the work that are timed apart; the names are those that reports print.
enum class Part { elasticity, muscles, contact, hyoid, inertia, assembly, factorisation, solve, count };

inline constexpr std::array<const char*, static_cast<std::size_t>(Part::count)> part_names{
    "elasticity", "muscles", "contact", "hyoid", "inertia", "assembly", "factorisation", "solve"};

struct Seconds {
  std::array<double, static_cast<std::size_t>(Part::count)> of{};
  double total = 0.0;
};

/// Adds the time between construction and destruction to one part.
class Stopwatch {
 public:
  Stopwatch(Seconds& seconds, Part part) : slot_(seconds.of[static_cast<std::size_t>(part)]) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { slot_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

 private:
  double& slot_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace glossa

#include "core/parallel.hpp"

#include <doctest/doctest.h>

#include <vector>

namespace glossa {

TEST_CASE("parallel_ranges: every item is visited once, whatever the number of threads") {
  for (const int count : {0, 1, 63, 64, 191, 192, 1000})
    for (const int threads : {-1, 0, 1, 2, 3, 7}) {
      std::vector<int> visits(static_cast<std::size_t>(count), 0);
      parallel_ranges(count, threads, [&](int begin, int end) {
        for (int k = begin; k < end; ++k) ++visits[static_cast<std::size_t>(k)];
      });
      CAPTURE(count);
      CAPTURE(threads);
      CHECK(visits == std::vector<int>(static_cast<std::size_t>(count), 1));
    }
}

TEST_CASE("parallel_ranges: long loops are split into as many ranges as threads") {
  std::vector<int> begins(1000, 0);
  parallel_ranges(1000, 3, [&](int begin, int) { begins[static_cast<std::size_t>(begin)] = 1; });
  int parts = 0;
  for (const int b : begins) parts += b;
  CHECK(parts == 3);
}

}  // namespace glossa

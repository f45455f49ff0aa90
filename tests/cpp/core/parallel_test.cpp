#include "core/parallel.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#ifdef __unix__
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace glossa {

TEST_CASE("parallel_ranges: every item is visited once, whatever the number of threads") {
  for (const int count : {0, 1, 31, 63, 64, 191, 192, 1000})
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

TEST_CASE("parallel_ranges: short loops are not split, long ones into two ranges for each thread") {
  const auto parts = [](int count, int threads) {
    std::vector<int> begins(static_cast<std::size_t>(count), 0);
    parallel_ranges(count, threads, [&](int begin, int) { begins[static_cast<std::size_t>(begin)] = 1; });
    return std::count(begins.begin(), begins.end(), 1);
  };
  CHECK(parts(63, 3) == 1);
  CHECK(parts(64, 3) == 2);
  CHECK(parts(1000, 3) == 6);
}

TEST_CASE("parallel_items: ten thousand short loops on all processors, each item once") {
  std::array<int, 20> sum{};
  for (int loop = 0; loop < 10000; ++loop)
    parallel_items(20, 64, [&](int item) { ++sum[static_cast<std::size_t>(item)]; });
  for (const int s : sum) CHECK(s == 10000);
}

TEST_CASE("parallel_items: loops within loops and of several threads at once are done as well") {
  std::atomic<int> done{0};
  const auto work = [&] {
    for (int loop = 0; loop < 200; ++loop)
      parallel_items(8, 4, [&](int) { parallel_items(8, 4, [&](int) { ++done; }); });
  };
  std::thread other(work);
  work();
  other.join();
  CHECK(done == 2 * 200 * 64);
}

TEST_CASE("parallel_items: an exception of an item reaches the caller, and the next loop works") {
  for (const int threads : {1, 4}) {
    CHECK_THROWS_AS(parallel_items(100, threads,
                                   [](int item) {
                                     if (item == 7) throw std::runtime_error("seven");
                                   }),
                    std::runtime_error);
    std::atomic<int> done{0};
    parallel_items(100, threads, [&](int) { ++done; });
    CHECK(done == 100);
  }
}

#ifdef __unix__
TEST_CASE("parallel_items: a forked child, which has none of the helpers, works on") {
  std::atomic<int> done{0};
  parallel_items(100, 4, [&](int) { ++done; });
  const pid_t child = fork();
  if (child == 0) {
    for (int loop = 0; loop < 100; ++loop) parallel_items(100, 4, [&](int) { ++done; });
    _exit(done == 10100 ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  CHECK(status == 0);
}
#endif

}  // namespace glossa

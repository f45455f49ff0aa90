// Loops over independent items, whole or in contiguous ranges, on several threads.
#pragma once

#include <algorithm>

#include "core/thread_team.hpp"

namespace glossa {

/// Calls body(item) for every item of [0, count) on up to `threads` threads, in no certain order. The body must write
/// only to places that belong to its item, so that the result has the same bits for every number of threads.
template <class Body>
void parallel_items(int count, int threads, const Body& body) {
  const auto call = [](const void* context, int item) { (*static_cast<const Body*>(context))(item); };
  share_out(count, threads, {call, &body});
}

/// Calls body(begin, end) for contiguous ranges of [0, count), two for each thread, of at least `least` items each:
/// less is too little work to share. The same holds for what the body writes.
template <class Body>
void parallel_ranges(int count, int threads, const Body& body, int least = 32) {
  const int ranges = threads < 2 ? 1 : std::min(2 * threads, count / least);
  if (ranges < 2) {
    body(0, count);
    return;
  }
  const auto cut = [&](int k) { return static_cast<int>(static_cast<long long>(count) * k / ranges); };
  parallel_items(ranges, threads, [&](int range) { body(cut(range), cut(range + 1)); });
}

}  // namespace glossa

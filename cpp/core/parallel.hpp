// Loops over independent items, split into contiguous ranges.
#pragma once

#include <utility>

namespace glossa {

/// Calls body(begin, end) for `threads` contiguous ranges of [0, count), or once where that leaves fewer than `least`
/// items to each: too little work for a thread. The body must write only to places that belong to its range, so that
/// the result has the same bits for every number of threads.
template <class Body>
void parallel_ranges(int count, int threads, Body&& body, int least = 64) {
  const int parts = threads < 1 ? 1 : threads;
  if (parts == 1 || count < least * parts) {
    body(0, count);
    return;
  }
#pragma omp parallel for num_threads(parts) schedule(static)
  for (int part = 0; part < parts; ++part) {
    const auto cut = [&](int k) { return static_cast<int>(static_cast<long long>(count) * k / parts); };
    body(cut(part), cut(part + 1));
  }
}

}  // namespace glossa

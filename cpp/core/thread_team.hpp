// Helper threads that share out the items of a loop with the thread that asks for it.
//
// The asking thread works itself and never waits for a helper that has not begun: where other programs keep the other
// processors busy, it does all items alone and loses nothing. (OpenMP waits for each thread of its team at the end of
// each loop, which on a busy machine costs a time slice of the scheduler for a loop of 50 us.) Helpers look out for
// work for some hundred microseconds before they sleep, because the loops of a solve follow each other closely.
#pragma once

namespace glossa {

/// An item of a loop.
struct SharedBody {
  void (*call)(const void* context, int item);
  const void* context;
};

/// Calls body for every item of [0, count), each once, on the calling thread and at most `threads` - 1 helpers; no more
/// helpers than there are other processors. Returns when all are done. The first exception of an item is thrown again
/// here, after which further items may not have been done. A loop within a loop, and a loop of a second thread at the
/// same time, run on the thread that asks.
void share_out(int count, int threads, SharedBody body);

}  // namespace glossa

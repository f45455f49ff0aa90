#include "core/thread_team.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

#if defined(__unix__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace glossa {
namespace {

constexpr unsigned looks_before_sleep = 40000;  // some 0.5 to 1 ms

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

long process() {
#if defined(__unix__) || defined(__APPLE__)
  return static_cast<long>(getpid());
#else
  return 0;
#endif
}

class Team {
 public:
  explicit Team(long process) : process_(process) {}

  /// Whether its helpers live: a forked child has none of them.
  [[nodiscard]] bool of(long process) const { return process_ == process; }

  /// False without having done anything if the team is at work already.
  bool share_out(int count, int helpers, SharedBody body) {
    const std::unique_lock<std::mutex> lock(busy_, std::try_to_lock);
    if (!lock.owns_lock()) return false;
    while (helpers_ < helpers) hire();
    body_ = body;
    count_ = count;
    thrown_ = nullptr;
    next_.store(0, std::memory_order_relaxed);
    places_.store(helpers, std::memory_order_relaxed);
    open_.store(true);
    call_.fetch_add(1);
    call_.notify_all();
    work();
    // A helper enters before it looks whether the loop is open: it either sees it closed or is waited for.
    open_.store(false);
    for (unsigned look = 0; inside_.load() != 0; ++look)
      look < looks_before_sleep ? pause() : std::this_thread::yield();
    if (thrown_) std::rethrow_exception(thrown_);
    return true;
  }

 private:
  void hire() {
    std::thread([this, seen = call_.load()] { help(seen); }).detach();
    ++helpers_;
  }

  // Never returns: the team lives as long as the process.
  [[noreturn]] void help(unsigned seen) {
    for (;;) {
      for (unsigned look = 0; call_.load() == seen; ++look) look < looks_before_sleep ? pause() : call_.wait(seen);
      seen = call_.load();
      inside_.fetch_add(1);
      if (open_.load() && places_.fetch_sub(1) > 0) work();
      inside_.fetch_sub(1);
    }
  }

  void work() {
    for (int item; (item = next_.fetch_add(1, std::memory_order_relaxed)) < count_;) {
      try {
        body_.call(body_.context, item);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(throwing_);
        if (!thrown_) thrown_ = std::current_exception();
        next_.store(count_, std::memory_order_relaxed);
      }
    }
  }

  const long process_;
  std::mutex busy_, throwing_;
  int helpers_ = 0;
  SharedBody body_{};
  int count_ = 0;
  std::exception_ptr thrown_;
  std::atomic<int> next_{0}, places_{0}, inside_{0};
  std::atomic<bool> open_{false};
  std::atomic<unsigned> call_{0};
};

// Not destroyed, as its threads may outlive the end of main.
Team& team() {
  static std::mutex founding;
  static std::atomic<Team*> present{nullptr};
  const long here = process();
  Team* found = present.load();
  if (found == nullptr || !found->of(here)) {
    const std::lock_guard<std::mutex> lock(founding);
    found = present.load();
    if (found == nullptr || !found->of(here)) {
      found = new Team(here);
      present.store(found);
    }
  }
  return *found;
}

}  // namespace

void share_out(int count, int threads, SharedBody body) {
  static const int processors = static_cast<int>(std::thread::hardware_concurrency());
  const int helpers = std::min({threads, processors, count}) - 1;
  if (helpers > 0 && team().share_out(count, helpers, body)) return;
  for (int item = 0; item < count; ++item) body.call(body.context, item);
}

}  // namespace glossa

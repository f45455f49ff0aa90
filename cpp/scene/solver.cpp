#include "scene/solver.hpp"

#include "core/error.hpp"

namespace glossa {

std::shared_ptr<System> Solver::system(const FreeMask& free, const std::vector<bool>& commanded) {
  require(free.size() == scene_.mesh().nodes().size(), "free components: three per node are needed");
  require(commanded.size() == static_cast<std::size_t>(scene_.options().muscle_count),
          "commands: one per muscle is needed");
  for (auto it = entries_.begin(); it != entries_.end(); ++it)
    if (it->free == free && it->commanded == commanded) {
      entries_.splice(entries_.begin(), entries_, it);
      return entries_.front().system;
    }
  entries_.push_front({free, commanded, std::make_shared<System>(scene_, free, commanded)});
  if (entries_.size() > kept) entries_.pop_back();
  return entries_.front().system;
}

}  // namespace glossa

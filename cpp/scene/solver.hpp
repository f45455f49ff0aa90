// Solves of one scene, with layouts and symbolic analyses kept between them.
#pragma once

#include <list>

#include "scene/equilibrium.hpp"

namespace glossa {

/// Owns a scene and the few Systems used last. Not for use by two threads at once.
class Solver {
 public:
  explicit Solver(Scene scene) : scene_(std::move(scene)) {}
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  [[nodiscard]] const Scene& scene() const { return scene_; }
  /// The system for a set of movable components and commanded muscles, laid out on first use.
  [[nodiscard]] std::shared_ptr<System> system(const FreeMask& free, const std::vector<bool>& commanded);

 private:
  struct Entry {
    FreeMask free;
    std::vector<bool> commanded;
    std::shared_ptr<System> system;
  };
  static constexpr std::size_t kept = 4;
  Scene scene_;
  std::list<Entry> entries_;  // most recent first
};

}  // namespace glossa

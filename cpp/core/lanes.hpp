// How many elements a kernel works on at once.
#pragma once

namespace glossa {

inline constexpr int lanes = 4;

}  // namespace glossa

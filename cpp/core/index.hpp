// The integer that counts nodes, elements and fibres.
#pragma once

#include <cstdint>

namespace glossa {

using Index = std::int32_t;

}  // namespace glossa

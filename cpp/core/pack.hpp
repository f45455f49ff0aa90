// Four doubles that are worked on at once: one lane for each of four hexahedra.
//
// The compiler's vector extension is used, so the same source gives AVX2, SSE2, NEON or plain scalar
// instructions; a kernel written with Pack has no branch between lanes.
#pragma once

#include <cstdint>

#include "core/lanes.hpp"

// Inlined even without optimisation: the function would otherwise exist once for several instruction sets.
#define GLOSSA_ALWAYS_INLINE static inline __attribute__((always_inline))

namespace glossa {

typedef double Pack __attribute__((vector_size(lanes * sizeof(double)), aligned(32)));
typedef std::int64_t PackBits __attribute__((vector_size(lanes * sizeof(std::int64_t)), aligned(32)));

/// All lanes equal to `value`.
GLOSSA_ALWAYS_INLINE Pack splat(double value) {
  return Pack{value, value, value, value};
}

/// x^(-1/3) for x > 0, to rounding. A guess from the exponent bits is improved by Newton's iteration
/// y <- y (4 - x y^3) / 3, whose relative error goes from e to about 2 e^2. Lanes with x <= 0 return rubbish.
GLOSSA_ALWAYS_INLINE Pack inverse_cube_root(Pack x) {
  PackBits bits = reinterpret_cast<PackBits>(x);
  bits = std::int64_t{0x553EF0FF289DD796} - bits / 3;
  Pack y = reinterpret_cast<Pack>(bits);
  for (int sweep = 0; sweep < 4; ++sweep) y = y * (4.0 - x * y * y * y) * (1.0 / 3.0);
  return y;
}

}  // namespace glossa

// Four doubles that are worked on at once: one lane for each of four hexahedra.
//
// The compiler's vector extension is used, so the same source gives AVX2, SSE2, NEON or plain scalar
// instructions; a kernel written with Pack has no branch between lanes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/index.hpp"
#include "core/lanes.hpp"

// Inlined even without optimisation: the function would otherwise exist once for several instruction sets.
#define GLOSSA_ALWAYS_INLINE static inline __attribute__((always_inline))

// Elements i .. l of eight: those of a, then those of b.
#ifdef __clang__
#define GLOSSA_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define GLOSSA_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, PackBits{i, j, k, l})
#endif

namespace glossa {

typedef double Pack __attribute__((vector_size(lanes * sizeof(double)), aligned(32)));
typedef std::int64_t PackBits __attribute__((vector_size(lanes * sizeof(std::int64_t)), aligned(32)));

/// All lanes equal to `value`.
GLOSSA_ALWAYS_INLINE Pack splat(double value) {
  return Pack{value, value, value, value};
}

typedef double LoosePack __attribute__((vector_size(lanes * sizeof(double)), aligned(8), may_alias));

/// `lanes` doubles at any address.
GLOSSA_ALWAYS_INLINE Pack load(const double* from) {
  return *reinterpret_cast<const LoosePack*>(from);
}
GLOSSA_ALWAYS_INLINE void store(double* to, Pack value) {
  *reinterpret_cast<LoosePack*>(to) = value;
}
GLOSSA_ALWAYS_INLINE Pack smaller(Pack a, Pack b) {
  return a < b ? a : b;
}

/// Turns four packs, the rows of a matrix, into its columns.
GLOSSA_ALWAYS_INLINE void transpose(Pack& a, Pack& b, Pack& c, Pack& d) {
  const Pack even_ab = GLOSSA_SHUFFLE(a, b, 0, 4, 2, 6), odd_ab = GLOSSA_SHUFFLE(a, b, 1, 5, 3, 7);
  const Pack even_cd = GLOSSA_SHUFFLE(c, d, 0, 4, 2, 6), odd_cd = GLOSSA_SHUFFLE(c, d, 1, 5, 3, 7);
  a = GLOSSA_SHUFFLE(even_ab, even_cd, 0, 1, 4, 5);
  b = GLOSSA_SHUFFLE(odd_ab, odd_cd, 0, 1, 4, 5);
  c = GLOSSA_SHUFFLE(even_ab, even_cd, 2, 3, 6, 7);
  d = GLOSSA_SHUFFLE(odd_ab, odd_cd, 2, 3, 6, 7);
}

/// The vectors of each element's nodes from a field of four doubles for each node, the last of them unused.
template <int count>
GLOSSA_ALWAYS_INLINE void gather(const double* field, const Index (&corner)[count][lanes], Pack (&x)[count][3]) {
  for (int n = 0; n < count; ++n) {
    Pack node[lanes];
    for (int lane = 0; lane < lanes; ++lane) node[lane] = load(field + 4 * static_cast<std::size_t>(corner[n][lane]));
    transpose(node[0], node[1], node[2], node[3]);
    for (int i = 0; i < 3; ++i) x[n][i] = node[i];
  }
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

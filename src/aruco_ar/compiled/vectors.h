/* For loops that compilers can vectorize. */
#pragma once

/* A function is made twice: for every processor, and for those whose vectors have 32 bytes. Which one is called is
   found out when the library is loaded. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define FAST __attribute__((target_clones("avx2", "default")))
#else
#define FAST
#endif

/* A function that becomes a part of those that call it, so that it is as fast as they are. */
#define INLINE static inline __attribute__((always_inline))

/* Four numbers side by side, of which the processor computes all at once. */
typedef float Four __attribute__((vector_size(16)));

INLINE float sum_of(Four values) { return values[0] + values[1] + values[2] + values[3]; }

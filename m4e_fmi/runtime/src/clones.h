/* Functions with vector loops are compiled for several instruction sets, chosen at load time. */
#ifndef M4E_CLONES
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__)
#define M4E_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define M4E_CLONES
#endif

/* A loop over lanes l that carries nothing from one to the next. */
#if defined(__clang__)
#define M4E_EACH_LANE _Pragma("clang loop vectorize(assume_safety)") \
    for (size_t l = 0; l < M4E_LANES; ++l)
#elif defined(__GNUC__)
#define M4E_EACH_LANE _Pragma("GCC ivdep") for (size_t l = 0; l < M4E_LANES; ++l)
#else
#define M4E_EACH_LANE for (size_t l = 0; l < M4E_LANES; ++l)
#endif
#endif

/* One rounding per operation, whatever flags a compiler is called with: the sources also travel
   inside FMUs, where others compile them. A product and a sum are never fused into one. */
#ifndef M4E_EXACT_H
#define M4E_EXACT_H

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "results would depend on the compiler: compile without -ffast-math, /fp:fast"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#endif

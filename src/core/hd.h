// SPDX-License-Identifier: MIT
/* Marks functions that gcc, clang and nvcc all compile, for the processor and the GPU alike. */
#ifndef QNI_CORE_HD_H
#define QNI_CORE_HD_H

#ifdef __CUDACC__
#define QN_HD __host__ __device__
#else
#define QN_HD
#endif

#if defined(__CUDACC__)
#define QN_HD_INLINE QN_HD static __forceinline__
#elif defined(__GNUC__)
#define QN_HD_INLINE static inline __attribute__((always_inline, unused))
#else
#define QN_HD_INLINE static inline
#endif

/* Before a loop that nvcc shall not unroll: its body is large, or seldom entered. */
#if defined(__CUDA_ARCH__)
#define QN_ROLLED _Pragma("unroll 1")
#else
#define QN_ROLLED
#endif

/* What is rarely called and large: on the GPU a function of its own, so that it takes no registers
 * from those who call it. */
#if defined(__CUDACC__)
#define QN_HD_APART QN_HD static __noinline__
#else
#define QN_HD_APART static inline
#endif

#endif

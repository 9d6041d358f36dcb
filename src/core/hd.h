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

#endif

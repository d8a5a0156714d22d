// SPDX-License-Identifier: MIT
// CPU features. Kernels come in variants that give the same bits; each room chooses with this. The
// environment variable STP_PROCESSOR=baseline|avx2|avx512|neon lowers the answer, for tests.
#pragma once

#include <stdint.h>

typedef enum stp_processor {
    STP_PROCESSOR_BASELINE, ///< portable C
    STP_PROCESSOR_VECTOR,   ///< x86-64-v3: AVX2, BMI, F16C; or aarch64: NEON
    STP_PROCESSOR_WIDE,     ///< x86-64-v4: AVX-512 F, BW, CD, DQ, VL
} stp_processor;

/// Names of a kernel's variants: NAME_wide and NAME_vector, or the next narrower one that this
/// build has. None uses fused multiply-add.
#if defined(__x86_64__) || defined(__aarch64__)
#define STP_VECTOR(name) name##_vector
#else
#define STP_VECTOR(name) name##_portable
#endif
#if defined(__x86_64__)
#define STP_WIDE(name) name##_wide
#else
#define STP_WIDE(name) STP_VECTOR(name)
#endif

/// The variant of a kernel for a processor. `&name` is an address. Evaluates `processor` more than
/// once.
#define STP_VARIANT(processor, name)                                                               \
    ((processor) == STP_PROCESSOR_WIDE     ? STP_WIDE(name)                                        \
     : (processor) == STP_PROCESSOR_VECTOR ? STP_VECTOR(name)                                      \
                                           : name##_portable)
/// The same for kernels without a wide variant.
#define STP_VARIANT_OF_TWO(processor, name)                                                        \
    ((processor) != STP_PROCESSOR_BASELINE ? STP_VECTOR(name) : name##_portable)

/// The widest variant that this CPU runs. Any thread; cheap enough for one query per library call.
stp_processor stp_processor_detect(void);

/// Its name here: baseline, avx2, avx512 or neon.
const char* stp_processor_name(stp_processor processor);

/// Number of CPUs available to this process: 1..1024.
uint32_t stp_processor_count(void);

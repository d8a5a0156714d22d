// SPDX-License-Identifier: MIT
//
// Measures the library's SIMD kernels. A kernel has a portable variant, one for AVX2 or NEON, and
// perhaps one for AVX-512; all must give the same bits. Each is called through the function that
// selects a variant for this CPU, with STP_PROCESSOR set, on the same random input.
#pragma once

#include "base/core/arena.h"
#include "base/core/processor.h"

enum { KERNEL_VARIANTS = STP_PROCESSOR_WIDE + 1, KERNEL_RUNS_MAX = 101 };

/// Input and output of a kernel.
typedef struct kernel_case {
    stp_arena* arena; ///< of both
    void* input;
    void* output; ///< compared between variants
    size_t output_bytes;
    uint64_t elements; ///< processed by one run
} kernel_case;

typedef struct kernel {
    const char* name;
    const char* source;   ///< path of its files, without the suffixes of instruction sets and of C
    stp_processor widest; ///< variant
    const char* element;  ///< what a run processes
    /// Fills the case. @return false if out of memory (not logged)
    bool (*make)(kernel_case* c);
    /// Restores what a run changes; NULL: fills the output with ones. Not timed.
    void (*reset)(kernel_case* c);
    void (*run)(kernel_case* c);
    void (*destroy)(kernel_case* c); ///< of what is not in the arena; may be NULL
} kernel;

/// Nanoseconds of CPU time per element.
typedef struct kernel_times {
    double median, min, max;
} kernel_times;

typedef struct kernel_result {
    uint64_t elements;
    uint32_t runs;
    uint32_t variants; ///< measured, from the portable one up
    kernel_times times[KERNEL_VARIANTS];
    bool same[KERNEL_VARIANTS]; ///< as the portable variant, to the bit
} kernel_result;

/// All kernels; one without a name at the end.
extern const kernel kernels[];

/// Runs all variants that this CPU has, taking turns. Changes STP_PROCESSOR meanwhile.
/// @return false if out of memory (not logged)
bool kernel_measure(stp_context* context, const kernel* k, uint32_t runs, kernel_result* result);

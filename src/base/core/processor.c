// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // _SC_NPROCESSORS_ONLN
#include "base/core/processor.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#if defined(__x86_64__)
/// F16C and LZCNT, which older compilers cannot ask for by name.
static bool has_halves_and_lzcnt(void)
{
    const unsigned f16c = 1u << 29, lzcnt = 1u << 5; // in ECX
    unsigned a, b, c, d;
    return __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & f16c) != 0 &&
           __get_cpuid(0x80000001u, &a, &b, &c, &d) != 0 && (c & lzcnt) != 0;
}
#endif

static stp_processor ask_hardware(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    int avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
               __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt") &&
               has_halves_and_lzcnt();
    if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) {
        return STP_PROCESSOR_WIDE;
    }
    return avx2 ? STP_PROCESSOR_VECTOR : STP_PROCESSOR_BASELINE;
#elif defined(__aarch64__)
    return STP_PROCESSOR_VECTOR; // NEON is part of the architecture
#else
    return STP_PROCESSOR_BASELINE;
#endif
}

/// The same for as long as the process runs, so it is asked once: CPUID takes many microseconds in a
/// virtual machine, and drawing asks for each batch.
static stp_processor detect_hardware(void)
{
    static _Atomic int known = -1;
    int found = atomic_load_explicit(&known, memory_order_relaxed);
    if (found < 0) {
        found = (int)ask_hardware();
        atomic_store_explicit(&known, found, memory_order_relaxed);
    }
    return (stp_processor)found;
}

const char* stp_processor_name(stp_processor processor)
{
#if defined(__aarch64__)
    static const char* const names[] = {"baseline", "neon", "neon"};
#else
    static const char* const names[] = {"baseline", "avx2", "avx512"};
#endif
    assert(processor <= STP_PROCESSOR_WIDE);
    return names[processor];
}

stp_processor stp_processor_detect(void)
{
    stp_processor found = detect_hardware();
    const char* wanted = getenv("STP_PROCESSOR");
    for (stp_processor p = STP_PROCESSOR_BASELINE; wanted != NULL && p < found; ++p) {
        if (strcmp(wanted, stp_processor_name(p)) == 0) {
            return p;
        }
    }
    return found;
}

uint32_t stp_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > 1024 ? 1024 : (uint32_t)count;
}

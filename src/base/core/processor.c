// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // _SC_NPROCESSORS_ONLN
#include "base/core/processor.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static stp_processor detect_hardware(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    int avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
               __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
    if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) {
        return STP_PROCESSOR_AVX512;
    }
    return avx2 ? STP_PROCESSOR_AVX2 : STP_PROCESSOR_BASELINE;
#else
    return STP_PROCESSOR_BASELINE;
#endif
}

stp_processor stp_processor_detect(void)
{
    stp_processor found = detect_hardware();
    const char* wanted = getenv("STP_PROCESSOR");
    if (wanted != NULL && strcmp(wanted, "baseline") == 0) {
        return STP_PROCESSOR_BASELINE;
    }
    if (wanted != NULL && strcmp(wanted, "avx2") == 0 && found > STP_PROCESSOR_AVX2) {
        return STP_PROCESSOR_AVX2;
    }
    return found;
}

uint32_t stp_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > 1024 ? 1024 : (uint32_t)count;
}

// SPDX-License-Identifier: MIT
// CPU features. Kernels come in variants that give the same bits; each room chooses with this. The
// environment variable STP_PROCESSOR=baseline|avx2|avx512 lowers the answer, for tests.
#pragma once

#include <stdint.h>

typedef enum stp_processor {
    STP_PROCESSOR_BASELINE, ///< portable C
    STP_PROCESSOR_AVX2,     ///< x86-64-v3: AVX2, BMI, F16C (fused multiply-add is never used)
    STP_PROCESSOR_AVX512,   ///< x86-64-v4: AVX-512 F, BW, CD, DQ, VL
} stp_processor;

/// The widest variant that this CPU runs. Any thread; cheap enough for one query per library call.
stp_processor stp_processor_detect(void);

/// Number of CPUs available to this process: 1..1024.
uint32_t stp_processor_count(void);

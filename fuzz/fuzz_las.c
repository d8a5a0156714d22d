// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_las -max_total_time=60 -max_len=4096 build/corpus/fuzz_las
// Seeds: build/corpus/las/*
//
// Create the seeds with: STP_LAS_SEEDS=$PWD/build/corpus/las stp_tests las_writes_seeds
// Arbitrary bytes as LAS: rejected, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.laz", data, size);
    return 0;
}

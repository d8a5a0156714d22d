// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_las -max_total_time=60 -max_len=4096 build/corpus/fuzz_las
// Seeds: build/corpus/las/*
//
// STP_LAS_SEEDS=build/corpus/las stp_tests las_writes_seeds makes the seeds.
// Any bytes as LAS: refused, or a sound scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.laz", data, size);
    return 0;
}

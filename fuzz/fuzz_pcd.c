// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_pcd -max_total_time=60 -max_len=4096 build/corpus/fuzz_pcd
// Seeds: the headers of tests/import/test_pcd.c
//
// Arbitrary bytes as PCD: rejected with one sentence, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.pcd", data, size);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_ptx -max_total_time=60 -max_len=4096 build/corpus/fuzz_ptx
// Seeds: the texts of tests/import/test_ptx.c
//
// Arbitrary bytes as PTX: rejected with one sentence, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.ptx", data, size);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_xyz -max_total_time=60 -max_len=4096 build/corpus/fuzz_xyz
// Seeds: lines of numbers, preceded by an x or a p
//
// Arbitrary bytes as a point text file: rejected with one sentence, or a valid scene. The first
// byte selects PTS or XYZ.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    if (size > 0) {
        fuzz_import(data[0] == 'p' ? "input.pts" : "input.csv", data + 1, size - 1);
    }
    return 0;
}

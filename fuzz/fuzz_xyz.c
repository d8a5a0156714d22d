// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_xyz -max_total_time=60 -max_len=4096 build/corpus/fuzz_xyz
// Seeds: texts of numbers, with an x or a p before them
//
// Any bytes as a text of points: refused with one sentence, or a sound scene. The first byte chooses PTS or XYZ.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    if (size > 0) {
        fuzz_import(data[0] == 'p' ? "input.pts" : "input.csv", data + 1, size - 1);
    }
    return 0;
}

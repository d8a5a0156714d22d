// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_ply -max_total_time=60 -max_len=4096 build/corpus/fuzz_ply
// Seeds: /usr/share/assimp/models/PLY/*.ply
//
// Arbitrary bytes as PLY: rejected, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.ply", data, size);
    return 0;
}

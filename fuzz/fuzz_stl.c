// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_stl -max_total_time=60 -max_len=4096 build/corpus/fuzz_stl
// Seeds: /usr/share/assimp/models/STL/*.stl
//
// Arbitrary bytes as STL: rejected, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.stl", data, size);
    return 0;
}

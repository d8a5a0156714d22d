// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_3mf -max_total_time=60 -max_len=4096 build/corpus/fuzz_3mf
// Seeds: /usr/share/assimp/models/3MF/*.3mf
//
// Arbitrary bytes as 3MF: rejected, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.3mf", data, size);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_off -max_total_time=60 -max_len=4096 build/corpus/fuzz_off
// Seeds: /usr/share/assimp/models/OFF/*.off
//
// Arbitrary bytes as OFF: rejected, or a valid scene.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_import("input.off", data, size);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_image_plain -max_total_time=60 -max_len=4096 build/corpus/fuzz_image_plain
//
// Arbitrary bytes as a TGA or BMP picture: rejected, or as many texels as it claims.
#include "fuzz.h"

#include "import/reading/surface.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    int errors = 0;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return 0;
    }
    stp_texture texture = {0};
    const char* reason = NULL;
    stp_result result = stp_image_decode_plain(context, data, size, &texture, &reason);
    if (result == STP_OK) {
        uint32_t sum = 0;
        for (size_t i = 0; i < 4 * (size_t)texture.width * texture.height; ++i) {
            sum += texture.texels[i];
        }
        if (sum == UINT32_MAX) { // reads every texel
            abort();
        }
        stp_free(context, texture.texels);
    } else if (reason == NULL) {
        abort();
    }
    stp_context_destroy(context);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// How to fuzz:
//   cmake --preset fuzz && cmake --build --preset fuzz --target fuzz_image
//   mkdir -p corpus && cp a few small pictures into it
//   build/fuzz/fuzz/fuzz_image -max_len=16384 -rss_limit_mb=4096 -timeout=10 corpus
// Seeds: /usr/share/assimp/models/*/*/*.png /usr/share/assimp/models/*/*.jpg /usr/share/assimp/models/*/*/*.jpg
#include "image/image_codecs.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    stp_context* context;
    const stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = (uint64_t)1 << 30};
    if (stp_context_create(&context, &desc) != STP_OK) {
        return 0;
    }
    stp_image texture = {0};
    unsigned sum = 0;
    if (stp_image_decode(context, "fuzz", bytes, size, &texture) == STP_OK) {
        for (size_t i = 0; i < (size_t)texture.width * texture.height * 4; ++i) {
            sum += texture.pixels[i]; // all pixels are readable
        }
    }
    stp_free(context, texture.pixels);
    stp_context_destroy(context);
    return sum == 0xFFFFFFFFu;
}

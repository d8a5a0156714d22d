// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_png -max_total_time=60 -max_len=4096 build/corpus/fuzz_png
// Seeds: /usr/share/assimp/models/*/*/*.png
//
// Arbitrary bytes as a PNG. A picture that can be read must survive a round trip.
#include "fuzz.h"

#include "program/present/picture_file.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    int errors = 0;
    stp_context* context = fuzz_context_create(&errors);
    if (context == NULL) {
        return 0;
    }
    stp_image image, again;
    if (stp_png_decode(context, "input", data, size, &image) == STP_OK) {
        unsigned char* bytes;
        size_t byte_count;
        if (stp_png_encode(context, &image, "input", &bytes, &byte_count) == STP_OK) {
            if (stp_png_decode(context, "again", bytes, byte_count, &again) == STP_OK) {
                size_t pixel_bytes = (size_t)image.width * image.height * 4;
                if (again.width != image.width || again.height != image.height ||
                    memcmp(again.pixels, image.pixels, pixel_bytes) != 0) {
                    abort();
                }
                stp_free(context, again.pixels);
            }
            stp_free(context, bytes);
        }
        stp_free(context, image.pixels);
    }
    stp_context_destroy(context);
    return 0;
}

// SPDX-License-Identifier: MIT
//
// stipple compare: similarity of two pictures.
#include "program/files/overwrite.h"
#include "program/measure/image_compare.h"
#include "program/options/command.h"
#include "program/present/picture_file.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIFFERENCE_GAIN = 8 }; // makes small differences visible

static struct {
    const char* mask;
    const char* map;
    const char* difference;
    uint64_t threads;
    bool json;
} args;

static const option* options(void)
{
    static const option table[] = {
        {.name = "mask",
         .type = OPTION_TEXT,
         .argument = "M.png",
         .help = "count only covered pixels where this mask is light (ssim_covered)",
         .value = &args.mask},
        {.name = "map",
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "write the SSIM of each pixel as a grey picture",
         .value = &args.map},
        {.name = "difference",
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "write the difference of each channel, times 8",
         .value = &args.difference},
        OPTION_THREADS(&args.threads),
        OPTION_JSON(&args.json),
        {0},
    };
    return table;
}

// Stores the amplified difference in `a`, which becomes opaque. Both are composited on black.
static void subtract(stp_image* a, const stp_image* b)
{
    assert(a->width == b->width && a->height == b->height && "compared before");
    for (size_t i = 0; i < (size_t)a->width * a->height; ++i) {
        uint8_t *p = a->pixels + 4 * i, *q = b->pixels + 4 * i;
        for (int c = 0; c < 3; ++c) {
            int d = abs((p[c] * p[3] + 127) / 255 - (q[c] * q[3] + 127) / 255) * DIFFERENCE_GAIN;
            p[c] = (uint8_t)(d < 255 ? d : 255);
        }
        p[3] = 255;
    }
}

static int print(const stp_image* image, const stp_image_quality* quality)
{
    if (args.json) {
        return tool_print_json(
            json_pack("{s:f, s:f, s:f, s:f, s:I, s:I}", "ssim", quality->ssim, "ssim_covered",
                      quality->ssim_covered, "ms_ssim", quality->ms_ssim, "psnr", quality->psnr,
                      "width", (json_int_t)image->width, "height", (json_int_t)image->height));
    }
    printf("ssim          %.6f\nssim_covered  %.6f\nms_ssim       %.6f\n", quality->ssim,
           quality->ssim_covered, quality->ms_ssim);
    if (quality->psnr >= STP_PSNR_EQUAL) {
        printf("psnr          infinite: the pictures are equal\n");
    } else {
        printf("psnr          %.3f dB\n", quality->psnr);
    }
    return 0;
}

static stp_result compare(stp_context* context, stp_image pictures[4], char** paths,
                          stp_image_quality* quality)
{
    stp_image *a = &pictures[0], *b = &pictures[1], *mask = &pictures[2], *map = &pictures[3];
    stp_result result = tool_read_picture(context, paths[0], a);
    result = result == STP_OK ? tool_read_picture(context, paths[1], b) : result;
    if (result == STP_OK && args.mask != NULL) {
        result = tool_read_picture(context, args.mask, mask);
    }
    if (result == STP_OK) {
        result = stp_image_compare(context, a, b, args.mask != NULL ? mask : NULL,
                                   args.map != NULL ? map : NULL, quality);
    }
    if (result == STP_OK && args.map != NULL) {
        result = tool_write_picture(context, map, args.map);
    }
    if (result == STP_OK && args.difference != NULL) {
        subtract(a, b);
        result = tool_write_picture(context, a, args.difference);
    }
    return result;
}

static bool is_stream(const char* path)
{
    return path != NULL && strcmp(path, "-") == 0;
}

static int check_outputs(char** pictures)
{
    const char* inputs[] = {pictures[0], pictures[1], args.mask};
    const char* outputs[] = {args.map, args.difference};
    for (int o = 0; o < 2; ++o) {
        int code = tool_check_picture(outputs[o]);
        for (int i = 0; i < 3 && code == 0; ++i) {
            code = overwrite_check(inputs[i], outputs[o]);
        }
        if (code != 0) {
            return code;
        }
    }
    return 0;
}

static int run(int argc, char** argv)
{
    if (argc != 2) {
        return tool_usage_error("compare needs two pictures, but got %d", argc);
    }
    if (is_stream(argv[0]) + is_stream(argv[1]) + is_stream(args.mask) > 1) {
        return tool_usage_error("only one picture can come from standard input");
    }
    if (is_stream(args.map) || is_stream(args.difference)) {
        return tool_usage_error("standard output receives the figures; give a file name");
    }
    int refused = check_outputs(argv);
    if (refused != 0) {
        return refused;
    }
    stp_context* context = tool_context_create((uint32_t)args.threads, 0, "none");
    if (context == NULL) {
        return 1;
    }
    stp_image pictures[4] = {{0}};
    stp_image_quality quality;
    stp_result result = compare(context, pictures, argv, &quality);
    int code = result == STP_OK ? print(&pictures[0], &quality) : 1;
    for (int i = 0; i < 4; ++i) {
        stp_free(context, pictures[i].pixels);
    }
    stp_context_destroy(context);
    return code;
}

const command command_compare = {
    .name = "compare",
    .arguments = "A.png B.png",
    .summary = "measure the similarity of two pictures: SSIM, MS-SSIM, PSNR",
    .text =
        "Composites both pictures on black, then compares them. ssim is the structural "
        "similarity of the luminance (Wang et al. 2004) with an 11 x 11 Gaussian window of sigma "
        "1.5, averaged over the pixels whose window lies within the picture. ssim_covered "
        "averages only over pixels that either picture covers (alpha above 0). ms_ssim uses five "
        "scales (Wang et al. 2003). psnr covers red, green and blue; for equal pictures it is "
        "infinite, which JSON shows as 200.\n\n"
        "Either picture, or the mask, may be - for standard input.\n\n"
        "The exit status is 0 whenever the pictures can be compared, however different they are, "
        "and 1 otherwise.",
    .examples =
        "Compare two pictures:\n"
        "$ stipple compare plant.png reference.png\n"
        "Show where they differ:\n"
        "$ stipple compare plant.png reference.png --map ssim.png --difference difference.png\n",
    .files = "A.png, B.png\tPNG files of the same size\n"
             "M.png\ta mask; its black pixels are ignored\n",
    .options = options,
    .run = run,
};

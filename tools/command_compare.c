// SPDX-License-Identifier: MIT
//
// stipple compare: how alike two pictures are.
#include "command.h"
#include "overwrite.h"
#include "picture.h"

#include "measure/image_compare.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIFFERENCE_GAIN = 8 }; // small differences should be seen

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
         .help = "count only covered pixels where this picture is light (ssim_covered)",
         .value = &args.mask},
        {.name = "map",
         .type = OPTION_TEXT,
         .argument = "OUT.png",
         .help = "write the SSIM of each pixel, as grey",
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

// Leaves the difference in `a`.
static void subtract(stp_image* a, const stp_image* b)
{
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
    result = result != STP_OK ? result : tool_read_picture(context, paths[1], b);
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
        return tool_usage_error("compare needs two pictures, and got %d", argc);
    }
    if (is_stream(argv[0]) + is_stream(argv[1]) + is_stream(args.mask) > 1) {
        return tool_usage_error("only one picture can come from standard input");
    }
    if (is_stream(args.map) || is_stream(args.difference)) {
        return tool_usage_error("standard output is for the figures; name a file");
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
    .summary = "measure how alike two pictures are: SSIM, MS-SSIM, PSNR",
    .text =
        "Both pictures are put on black first. ssim is the structural similarity of Wang et al. "
        "2004: of "
        "the luminance, with an 11 x 11 Gaussian window of sigma 1.5, as the mean over the pixels "
        "whose "
        "window lies within the picture. ssim_covered is the mean over the pixels that either "
        "picture "
        "covers (alpha above 0). ms_ssim takes five scales (Wang et al. 2003). psnr is over red, "
        "green and "
        "blue; for equal pictures it is infinite, which JSON shows as 200.\n"
        "\n"
        "Either picture, or the mask, may be - for standard input.\n"
        "\n"
        "Exit status is 0 however different the pictures are, and 1 where they cannot be compared.",
    .examples =
        "How alike two pictures are:\n"
        "$ stipple compare plant.png reference.png\n"
        "Where they differ:\n"
        "$ stipple compare plant.png reference.png --map ssim.png --difference difference.png\n",
    .files = "A.png, B.png\t"
             "PNG files of one size\n"
             "M.png\t"
             "a mask; pixels that are black in it do not count\n",
    .options = options,
    .run = run,
};

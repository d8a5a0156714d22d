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
    const char* exact;
    uint64_t threads;
    bool json;
} args;

/// The pictures of a comparison, and its results.
typedef struct comparison {
    stp_image a, b, mask, map, exact;
    stp_image_quality quality;
    double exact_truth; ///< covered SSIM of `exact` to `b`, if it is given
} comparison;

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
        {.name = "exact",
         .type = OPTION_TEXT,
         .argument = "E.png",
         .help = "B was drawn with 16 samples a pixel, E with one: also print the truth of A, that "
                 "of E, "
                 "and their ratio",
         .value = &args.exact},
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

static int print(const comparison* c)
{
    const stp_image_quality* q = &c->quality;
    double truth = q->ssim_covered;
    double ratio = stp_truth_ratio(truth, c->exact_truth);
    if (args.json) {
        json_t* root = json_pack("{s:f, s:f, s:f, s:f, s:I, s:I}", "ssim", q->ssim, "ssim_covered",
                                 q->ssim_covered, "ms_ssim", q->ms_ssim, "psnr", q->psnr, "width",
                                 (json_int_t)c->a.width, "height", (json_int_t)c->a.height);
        if (args.exact != NULL) {
            json_object_set_new(root, "truth", json_real(truth));
            json_object_set_new(root, "exact", json_real(c->exact_truth));
            json_object_set_new(root, "ratio", json_real(ratio));
        }
        return tool_print_json(root);
    }
    printf("ssim          %.6f\nssim_covered  %.6f\nms_ssim       %.6f\n", q->ssim, q->ssim_covered,
           q->ms_ssim);
    if (q->psnr >= STP_PSNR_EQUAL) {
        printf("psnr          infinite: the pictures are equal\n");
    } else {
        printf("psnr          %.3f dB\n", q->psnr);
    }
    if (args.exact != NULL) {
        printf("truth         %.6f\nexact         %.6f\nratio         %.6f\n", truth,
               c->exact_truth, ratio);
    }
    return 0;
}

static stp_result compare_exact(stp_context* context, comparison* c)
{
    stp_image_quality quality;
    stp_result result = tool_read_picture(context, args.exact, &c->exact);
    result = result == STP_OK ? stp_image_compare(context, &c->exact, &c->b, NULL, NULL, &quality)
                              : result;
    c->exact_truth = result == STP_OK ? quality.ssim_covered : 0.0;
    return result;
}

static stp_result compare(stp_context* context, char** paths, comparison* c)
{
    stp_result result = tool_read_picture(context, paths[0], &c->a);
    result = result == STP_OK ? tool_read_picture(context, paths[1], &c->b) : result;
    if (result == STP_OK && args.mask != NULL) {
        result = tool_read_picture(context, args.mask, &c->mask);
    }
    if (result == STP_OK) {
        result = stp_image_compare(context, &c->a, &c->b, args.mask != NULL ? &c->mask : NULL,
                                   args.map != NULL ? &c->map : NULL, &c->quality);
    }
    if (result == STP_OK && args.exact != NULL) {
        result = compare_exact(context, c);
    }
    if (result == STP_OK && args.map != NULL) {
        result = tool_write_picture(context, &c->map, args.map);
    }
    if (result == STP_OK && args.difference != NULL) {
        subtract(&c->a, &c->b);
        result = tool_write_picture(context, &c->a, args.difference);
    }
    return result;
}

static bool is_stream(const char* path)
{
    return path != NULL && strcmp(path, "-") == 0;
}

static int check_outputs(char** pictures)
{
    const char* inputs[] = {pictures[0], pictures[1], args.mask, args.exact};
    const char* outputs[] = {args.map, args.difference};
    for (int o = 0; o < 2; ++o) {
        int code = tool_check_picture(outputs[o]);
        for (int i = 0; i < 4 && code == 0; ++i) {
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
    if (is_stream(argv[0]) + is_stream(argv[1]) + is_stream(args.mask) + is_stream(args.exact) >
        1) {
        return tool_usage_error("only one picture can come from standard input");
    }
    if (args.exact != NULL && args.mask != NULL) {
        return tool_usage_error("--exact and --mask exclude each other");
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
    comparison c = {.exact_truth = 0.0};
    stp_result result = compare(context, argv, &c);
    int code = result == STP_OK ? print(&c) : 1;
    stp_image* pictures[] = {&c.a, &c.b, &c.mask, &c.map, &c.exact};
    for (int i = 0; i < 5; ++i) {
        stp_free(context, pictures[i]->pixels);
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
        "The truth of a picture is its ssim_covered to the originals with 16 samples a pixel. "
        "Originals with one sample are aliased and have a truth below 1, too; --exact shows the "
        "ratio to it.\n\n"
        "Either picture, or the mask, may be - for standard input.\n\n"
        "The exit status is 0 whenever the pictures can be compared, however different they are, "
        "and 1 otherwise.",
    .examples =
        "Compare two pictures:\n"
        "$ stipple compare plant.png reference.png\n"
        "Show where they differ:\n"
        "$ stipple compare plant.png reference.png --map ssim.png --difference difference.png\n"
        "Compare a frame with the truth:\n"
        "$ stipple render plant.stip -o truth.png --reference --supersample 4\n"
        "$ stipple render plant.stip -o exact.png --reference --supersample 1\n"
        "$ stipple compare frame.png truth.png --exact exact.png\n",
    .files = "A.png, B.png\tpictures of the same size: PNG, JPEG or WebP\n"
             "M.png\ta mask; its black pixels are ignored\n",
    .options = options,
    .run = run,
};

// SPDX-License-Identifier: MIT
#include "program/reports/reports.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MANY_TIMES 3.0
// About 10 ns each on one thread (docs/performance.md): a frame of 60 a second on two threads.
#define FEW_TRIANGLES 1000000u

static uint64_t size_of(const char* path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0
               ? (uint64_t)status.st_size
               : 0;
}

/// Total size of the files that an array of a glTF names, in the folder of the model. Names with
/// escapes count as 0.
static uint64_t sum_named(const json_t* root, const char* key, const char* model)
{
    const char* slash = strrchr(model, '/');
    int folder = slash != NULL ? (int)(slash - model) + 1 : 0;
    assert(folder >= 0 && "paths are shorter than INT_MAX");
    uint64_t sum = 0;
    size_t i;
    const json_t* value;
    json_array_foreach(json_object_get(root, key), i, value)
    {
        char path[4096];
        const char* name = json_string_value(json_object_get(value, "uri"));
        if (name != NULL && strncmp(name, "data:", 5) != 0 &&
            snprintf(path, sizeof(path), "%.*s%s", folder, model, name) < (int)sizeof(path)) {
            sum += size_of(path);
        }
    }
    return sum;
}

uint64_t build_sizes_input(const char* const* inputs, size_t count)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; ++i) {
        size_t length = strlen(inputs[i]);
        sum += size_of(inputs[i]);
        if (length > 5 && strcmp(inputs[i] + length - 5, ".gltf") == 0) {
            json_t* root = json_load_file(inputs[i], 0, NULL);
            sum += sum_named(root, "buffers", inputs[i]) + sum_named(root, "images", inputs[i]);
            json_decref(root);
        }
    }
    return sum;
}

/// Explains why a file is more than three times as large as its inputs, as an English sentence
/// without a full stop; NULL if it is not, or if the inputs have no size.
static const char* explain_size(uint64_t input_bytes, const scene_figures* figures)
{
    const stp_store_figures* f = &figures->summary.figures;
    if (input_bytes == 0 || (double)figures->file_bytes <= MANY_TIMES * (double)input_bytes) {
        return NULL;
    }
    uint64_t maximum = figures->file_bytes / 2;
    return f->splat_bytes > maximum      ? "splats; --surfels N keeps fewer of each node"
           : f->texture_bytes > maximum  ? "textures, which the input holds compressed"
           : f->triangle_bytes > maximum ? "triangles, which the input holds compressed"
           : f->point_bytes > maximum    ? "points, which the input holds compressed"
           : figures->file_bytes < 65536
               ? "the directory, tables and padding that any file has"
               : "neither splats nor triangles alone; the input is compressed";
}

bool build_sizes_needs_no_splats(const scene_figures* figures)
{
    const stp_store_figures* f = &figures->summary.figures;
    return f->unique_surfels > 0 && f->points == 0 && f->triangles <= FEW_TRIANGLES;
}

void build_sizes_print(uint64_t input_bytes, const scene_figures* figures)
{
    const stp_store_figures* f = &figures->summary.figures;
    char in[32], out[32], splats[32], triangles[32], textures[32], count[32];
    const char* reason = explain_size(input_bytes, figures);
    if (build_sizes_needs_no_splats(figures)) {
        printf("  %-12s the model is so small that its %s triangles suffice: --threshold %llu "
               "leaves out the splats\n",
               "notice", describe_count(f->triangles, count), (unsigned long long)f->triangles);
    }
    if (reason != NULL) {
        printf("  %-12s more than %.0f times the input: most of the file is %s\n", "notice",
               MANY_TIMES, reason);
    }
    if (input_bytes > 0) {
        printf("  %-12s %s in, %s out: ", "bytes", describe_bytes(input_bytes, in),
               describe_bytes(figures->file_bytes, out));
    } else {
        printf("  %-12s %s out: ", "bytes", describe_bytes(figures->file_bytes, out));
    }
    printf("%s splats, %s triangles, %s textures\n", describe_bytes(f->splat_bytes, splats),
           describe_bytes(f->triangle_bytes, triangles),
           describe_bytes(f->texture_bytes, textures));
}

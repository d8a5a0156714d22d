// SPDX-License-Identifier: MIT
// glTF files for tests, made in memory. JSON is written with single quotes, which become double
// ones.
#pragma once

#include "tests.h"

#include "import/reading/import.h"

#include <string.h>

#define GLTF_ASSET "'asset':{'version':'2.0'}"

typedef struct glb_file {
    unsigned char bytes[16384];
    size_t size;
} glb_file;

static inline void glb_put_u32(unsigned char* out, size_t value)
{
    for (int i = 0; i < 4; ++i) {
        out[i] = (unsigned char)(value >> (8 * i));
    }
}

static inline size_t gltf_quote(char* out, const char* json)
{
    size_t length = strlen(json);
    for (size_t i = 0; i <= length; ++i) {
        out[i] = json[i] == '\'' ? '"' : json[i];
    }
    return length;
}

/// Makes a .glb of JSON and a binary chunk, both padded. False if they do not fit.
static inline int glb_make(glb_file* glb, const char* json, const void* bin, size_t bin_size)
{
    size_t json_size = strlen(json), json_padded = (json_size + 3) & ~(size_t)3;
    size_t bin_padded = (bin_size + 3) & ~(size_t)3;
    glb->size = 12 + 8 + json_padded + 8 + bin_padded;
    if (glb->size + 1 > sizeof(glb->bytes)) {
        return 0;
    }
    memcpy(glb->bytes, "glTF", 4);
    glb_put_u32(glb->bytes + 4, 2);
    glb_put_u32(glb->bytes + 8, glb->size);
    glb_put_u32(glb->bytes + 12, json_padded);
    memcpy(glb->bytes + 16, "JSON", 4);
    gltf_quote((char*)glb->bytes + 20, json);
    memset(glb->bytes + 20 + json_size, ' ', json_padded - json_size);
    unsigned char* chunk = glb->bytes + 20 + json_padded;
    glb_put_u32(chunk, bin_padded);
    memcpy(chunk + 4, "BIN\0", 4);
    memset(chunk + 8, 0, bin_padded);
    if (bin_size != 0) {
        memcpy(chunk + 8, bin, bin_size);
    }
    return 1;
}

/// A context, a scene and the result of importing into it.
typedef struct gltf_run {
    test_log log;
    stp_context* context;
    stp_scene* scene;
    stp_result result;
} gltf_run;

static inline void gltf_run_begin(gltf_run* run, uint32_t threads)
{
    memset(run, 0, sizeof(*run));
    run->context = test_context(NULL, threads, &run->log);
    run->result = stp_scene_create(run->context, &run->scene);
}

static inline void gltf_run_glb(gltf_run* run, const char* json, const void* bin, size_t bin_size)
{
    glb_file glb;
    gltf_run_begin(run, 2);
    run->result = STP_ERROR_ARGUMENT;
    if (glb_make(&glb, json, bin, bin_size)) {
        const stp_import_desc desc = {0};
        run->result = stp_import_memory(run->scene, "test.glb", glb.bytes, glb.size, &desc);
    }
}

static inline void gltf_run_text(gltf_run* run, const char* json)
{
    char* quoted = malloc(strlen(json) + 1);
    gltf_run_begin(run, 2);
    const stp_import_desc desc = {0};
    run->result =
        stp_import_memory(run->scene, "test.gltf", quoted, gltf_quote(quoted, json), &desc);
    free(quoted);
}

static inline void gltf_run_end(gltf_run* run)
{
    stp_scene_destroy(run->scene);
    stp_context_destroy(run->context);
}

static inline int gltf_near(double a, double b)
{
    double difference = a - b;
    return difference < 1e-5 && difference > -1e-5;
}

// SPDX-License-Identifier: MIT
// EXT_meshopt_compression, and KHR_meshopt_compression as far as it is identical: buffer views
// encoded by libmeshoptimizer.
#include "import/gltf/gltf.h"

#include <assert.h>
#include <meshoptimizer.h>
#include <string.h>

#define VERTEX_STRIDE_LIMIT 256
// A byte of the vertex codec stands for at most 64 bytes of a block, one of the index codec for at
// most three indices of four bytes; the rest is slack for headers and tails.
#define EXPANSION_LIMIT 128

typedef enum compression_mode { MODE_ATTRIBUTES, MODE_TRIANGLES, MODE_INDICES } compression_mode;
typedef enum compression_filter {
    FILTER_NONE,
    FILTER_OCTAHEDRAL,
    FILTER_QUATERNION,
    FILTER_EXPONENTIAL,
} compression_filter;

typedef struct compressed_view {
    const unsigned char* bytes;
    size_t size, count, stride;
    compression_mode mode;
    compression_filter filter;
} compressed_view;

// Index of a word in a list; the list's length if it is not in it, 0 if it is missing.
static int find_word(const char* word, const char* const* words, int count)
{
    int found = 0;
    while (word != NULL && found < count && strcmp(word, words[found]) != 0) {
        found += 1;
    }
    assert(found >= 0 && found <= count);
    return found;
}

static stp_result check_view(stp_gltf_scope* scope, const compressed_view* view)
{
    bool is_good = view->stride == 2 || view->stride == 4;
    if (view->mode == MODE_ATTRIBUTES) {
        is_good = view->stride > 0 && view->stride <= VERTEX_STRIDE_LIMIT && view->stride % 4 == 0;
    }
    if (view->filter != FILTER_NONE) {
        is_good = view->mode == MODE_ATTRIBUTES &&
                  (view->filter == FILTER_OCTAHEDRAL   ? view->stride == 4 || view->stride == 8
                   : view->filter == FILTER_QUATERNION ? view->stride == 8
                                                       : is_good);
    }
    if (!is_good) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "byteStride %zu does not match the compression's mode and filter",
                             view->stride);
    }
    if (view->mode == MODE_TRIANGLES && view->count % 3 != 0) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%zu indices do not make triangles",
                             view->count);
    }
    assert(view->stride > 0 && view->stride <= VERTEX_STRIDE_LIMIT);
    if (view->count / EXPANSION_LIMIT > (view->size + EXPANSION_LIMIT) / view->stride) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "%zu bytes cannot hold %zu elements of %zu",
                             view->size, view->count, view->stride);
    }
    return STP_OK;
}

static stp_result read_view(stp_gltf_scope* scope, const json_t* json, compressed_view* view)
{
    static const char* const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static const char* const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    uint32_t buffer = STP_NONE;
    size_t offset = 0;
    stp_result result = stp_gltf_index(scope, json, "buffer", STP_GLTF_BUFFERS, &buffer);
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteOffset", &offset);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteLength", &view->size);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteStride", &view->stride);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "count", &view->count);
    }
    if (result != STP_OK) {
        return result;
    }
    const char* mode = stp_gltf_text(json, "mode");
    const char* filter = stp_gltf_text(json, "filter");
    int mode_index = find_word(mode, modes, 3);
    int filter_index = find_word(filter, filters, 4);
    if (buffer == STP_NONE || mode == NULL || mode_index == 3) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the compression lacks a buffer or a mode");
    }
    if (filter_index == 4) {
        return stp_gltf_fail(scope, STP_ERROR_UNSUPPORTED,
                             "the compression's filter %.40s is not supported", filter);
    }
    view->mode = (compression_mode)mode_index;
    view->filter = (compression_filter)filter_index;
    result = check_view(scope, view);
    return result == STP_OK ? stp_gltf_buffer_range(scope, buffer, offset, view->size, &view->bytes)
                            : result;
}

static stp_result decode_view(stp_gltf_scope* scope, const compressed_view* view,
                              unsigned char* out)
{
    assert(view->mode != MODE_TRIANGLES || view->count % 3 == 0);
    assert(view->filter == FILTER_NONE || view->mode == MODE_ATTRIBUTES);
    int error = 0;
    if (view->mode == MODE_ATTRIBUTES) {
        error = meshopt_decodeVertexBuffer(out, view->count, view->stride, view->bytes, view->size);
    } else if (view->mode == MODE_TRIANGLES) {
        error = meshopt_decodeIndexBuffer(out, view->count, view->stride, view->bytes, view->size);
    } else {
        error =
            meshopt_decodeIndexSequence(out, view->count, view->stride, view->bytes, view->size);
    }
    if (error != 0) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "the compressed data cannot be decoded (%d)",
                             error);
    }
    if (view->filter == FILTER_OCTAHEDRAL) {
        meshopt_decodeFilterOct(out, view->count, view->stride);
    } else if (view->filter == FILTER_QUATERNION) {
        meshopt_decodeFilterQuat(out, view->count, view->stride);
    } else if (view->filter == FILTER_EXPONENTIAL) {
        meshopt_decodeFilterExp(out, view->count, view->stride);
    }
    return STP_OK;
}

static stp_result decompress_view(stp_gltf_scope* scope, size_t index, const json_t* json,
                                  unsigned char** decoded)
{
    stp_context* context = scope->gltf->context;
    const json_t* extension;
    stp_result result = stp_gltf_extension(scope, json, "EXT_meshopt_compression", &extension);
    if (result == STP_OK && extension == NULL) {
        result = stp_gltf_extension(scope, json, "KHR_meshopt_compression", &extension);
    }
    if (result != STP_OK || extension == NULL) {
        return result;
    }
    stp_gltf_set_place(scope, "bufferViews[%zu]", index);
    compressed_view view = {0};
    size_t length = 0;
    result = read_view(scope, extension, &view);
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteLength", &length);
    }
    if (result != STP_OK) {
        return result;
    }
    if (length != view.count * view.stride) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "byteLength is %zu, but %zu elements of %zu bytes are compressed",
                             length, view.count, view.stride);
    }
    unsigned char* out = stp_alloc(context, length);
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *decoded = out; // freed with the others in any case
    return decode_view(scope, &view, out);
}

typedef struct view_loop {
    const stp_gltf* gltf;
    stp_result* results;
} view_loop;

// Processes a task of the loop: stores results only; the calling thread repeats the first failure
// to log it.
static void decompress_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const view_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        stp_gltf_scope scope = stp_gltf_scope_begin(loop->gltf);
        const json_t* json = json_array_get(loop->gltf->lists[STP_GLTF_BUFFER_VIEWS], i);
        loop->results[i] = decompress_view(&scope, i, json, &loop->gltf->decoded_views[i]);
    }
}

stp_result stp_gltf_decompress_views(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_BUFFER_VIEWS);
    bool any;
    stp_result result = stp_gltf_check_views(scope, gltf, &any);
    if (result != STP_OK || !any) {
        return result;
    }
    stp_result* results = STP_NEW_ZEROED(gltf->context, stp_result, count);
    gltf->decoded_views = STP_NEW_ZEROED(gltf->context, unsigned char*, count);
    if (results == NULL || gltf->decoded_views == NULL) {
        stp_free(gltf->context, results);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    view_loop loop = {.gltf = gltf, .results = results};
    stp_parallel_for(gltf->context, count, 1, decompress_job, &loop);
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        if (results[i] != STP_OK) {
            stp_free(gltf->context, gltf->decoded_views[i]);
            gltf->decoded_views[i] = NULL;
            const json_t* json = json_array_get(gltf->lists[STP_GLTF_BUFFER_VIEWS], i);
            result = decompress_view(scope, i, json, &gltf->decoded_views[i]);
        }
    }
    stp_free(gltf->context, results);
    return result;
}

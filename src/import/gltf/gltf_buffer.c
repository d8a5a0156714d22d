// SPDX-License-Identifier: MIT
// Buffers and buffer views (3.6.1): every range is checked against the actual data.
#include "import/gltf/gltf.h"

#include <assert.h>

static stp_result load_external(stp_gltf_scope* scope, const char* uri, stp_gltf_buffer* buffer)
{
    const stp_gltf* gltf = scope->gltf;
    char* reference;
    stp_result result = stp_gltf_uri_path(scope, uri, &reference);
    if (result != STP_OK) {
        return result;
    }
    const char* path = NULL;
    result = stp_import_resolve(gltf->import, reference, &path);
    stp_free(gltf->context, reference);
    if (result == STP_OK) {
        result = stp_file_map(gltf->context, path, &buffer->file);
    }
    buffer->bytes = buffer->file.bytes;
    buffer->size = buffer->file.size;
    return stp_gltf_logged(scope, result);
}

static stp_result load_buffer(stp_gltf_scope* scope, size_t index, stp_gltf* gltf)
{
    stp_gltf_buffer* buffer = &gltf->buffers[index];
    const json_t* json;
    size_t length = 0;
    stp_result result = stp_gltf_item(scope, STP_GLTF_BUFFERS, index, &json);
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteLength", &length);
    }
    if (result != STP_OK) {
        return result;
    }
    const char* uri = stp_gltf_text(json, "uri");
    if (uri == NULL && index == 0 && gltf->chunk != NULL) {
        buffer->bytes = gltf->chunk;
        buffer->size = gltf->chunk_size;
    } else if (uri == NULL) {
        // The fallback buffer of EXT_meshopt_compression: only compressed views refer to it, and
        // reading from it fails.
        return STP_OK;
    } else if (stp_gltf_uri_is_data(uri)) {
        result = stp_gltf_uri_decode(scope, uri, &buffer->owned, &buffer->size);
        buffer->bytes = buffer->owned;
    } else {
        result = load_external(scope, uri, buffer);
    }
    if (result != STP_OK) {
        return result;
    }
    if (length > buffer->size) {
        return stp_gltf_fail(scope, STP_ERROR_TRUNCATED,
                             "byteLength is %zu, but there are %zu bytes", length, buffer->size);
    }
    assert(buffer->bytes != NULL || length == 0);
    buffer->size = length;
    gltf->content_bytes += buffer->file.size;
    return STP_OK;
}

stp_result stp_gltf_load_buffers(stp_gltf_scope* scope, stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_BUFFERS);
    gltf->buffers = STP_NEW_ZEROED(gltf->context, stp_gltf_buffer, count);
    if (gltf->buffers == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; ++i) {
        stp_gltf_set_place(scope, "buffers[%zu]", i);
        stp_result result = load_buffer(scope, i, gltf);
        if (result != STP_OK) {
            return result;
        }
    }
    stp_gltf_set_place(scope, "%s", "");
    return STP_OK;
}

void stp_gltf_release_buffers(const stp_gltf* gltf)
{
    if (!gltf->import->alone) { // else the caller's memory, which this would discard
        stp_file_evict(&gltf->import->file);
    }
    for (size_t i = 0; i < stp_gltf_count(gltf, STP_GLTF_BUFFERS); ++i) {
        stp_file_evict(&gltf->buffers[i].file);
    }
}

void stp_gltf_free_buffers(stp_gltf* gltf)
{
    for (size_t i = 0; gltf->buffers != NULL && i < stp_gltf_count(gltf, STP_GLTF_BUFFERS); ++i) {
        stp_free(gltf->context, gltf->buffers[i].owned);
        stp_file_unmap(&gltf->buffers[i].file);
    }
    stp_free(gltf->context, gltf->buffers);
    for (size_t i = 0;
         gltf->decoded_views != NULL && i < stp_gltf_count(gltf, STP_GLTF_BUFFER_VIEWS); ++i) {
        stp_free(gltf->context, gltf->decoded_views[i]);
    }
    stp_free(gltf->context, gltf->decoded_views);
}

stp_result stp_gltf_buffer_range(stp_gltf_scope* scope, uint32_t buffer, size_t offset, size_t size,
                                 const unsigned char** bytes)
{
    assert(buffer < stp_gltf_count(scope->gltf, STP_GLTF_BUFFERS));
    const stp_gltf_buffer* from = &scope->gltf->buffers[buffer];
    if (from->bytes == NULL && size != 0) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "buffers[%u] has no data", buffer);
    }
    if (offset > from->size || size > from->size - offset) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT,
                             "bytes %zu to %zu lie outside buffers[%u], which has %zu bytes",
                             offset, offset + size, buffer, from->size);
    }
    *bytes = from->bytes != NULL ? from->bytes + offset : NULL;
    return STP_OK;
}

stp_result stp_gltf_view(stp_gltf_scope* scope, uint32_t view, const unsigned char** bytes,
                         size_t* size, size_t* stride)
{
    const json_t* json;
    uint32_t buffer = STP_NONE;
    size_t offset = 0;
    assert(view < stp_gltf_count(scope->gltf, STP_GLTF_BUFFER_VIEWS));
    *size = 0;
    *stride = 0;
    stp_result result = stp_gltf_item(scope, STP_GLTF_BUFFER_VIEWS, view, &json);
    if (result == STP_OK) {
        result = stp_gltf_index(scope, json, "buffer", STP_GLTF_BUFFERS, &buffer);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteOffset", &offset);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteLength", size);
    }
    if (result == STP_OK) {
        result = stp_gltf_size(scope, json, "byteStride", stride);
    }
    if (result != STP_OK) {
        return result;
    }
    if (scope->gltf->decoded_views != NULL && scope->gltf->decoded_views[view] != NULL) {
        *bytes = scope->gltf->decoded_views[view];
        return STP_OK;
    }
    if (buffer == STP_NONE) {
        return stp_gltf_fail(scope, STP_ERROR_FORMAT, "bufferViews[%u] has no buffer", view);
    }
    return stp_gltf_buffer_range(scope, buffer, offset, *size, bytes);
}

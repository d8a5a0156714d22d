// SPDX-License-Identifier: MIT
//
// Files kept by the caller: in memory, or behind a callback. A callback's file is read whole. With
// streaming, only the directory at the file's beginning is read; the residency reads the rest
// through the callback. The store still expects the file as one range of memory; untouched address
// space costs nothing.
#define _DEFAULT_SOURCE // MAP_ANONYMOUS, MAP_NORESERVE
#include "base/io/bytes.h"
#include "embed/model_internal.h"
#include "store/bytes/format.h"

#include <assert.h>
#include <string.h>
#include <sys/mman.h>

enum { ALIGNMENT = 64, BLOCK = 16 << 20, DATA_OFFSET_AT = 24 }; // docs/format.md, Header

bool stp_model_source_read(void* user, uint64_t offset, void* bytes, size_t size)
{
    stp_model_source* source = user;
    return source->read(source->read_user, offset, bytes, size) == 0;
}

static stp_result fail_read(const stp_model* model, const char* name, uint64_t offset)
{
    return stp_fail(model->context, STP_ERROR_IO, "%s: cannot be read at byte %llu", name,
                    (unsigned long long)offset);
}

static stp_result read_blocks(stp_model* model, const char* name, unsigned char* to, uint64_t size)
{
    assert(size <= model->source.size && "behind the end of the file");
    stp_result result = STP_OK;
    for (uint64_t at = 0; at < size && result == STP_OK; at += BLOCK) {
        size_t block = (size_t)(size - at < BLOCK ? size - at : BLOCK);
        result = stp_progress(model->context, "read", (double)at / (double)size);
        if (result == STP_OK && !stp_model_source_read(&model->source, at, to + at, block)) {
            result = fail_read(model, name, at);
        }
    }
    return result;
}

static stp_result copy_bytes(stp_model* model, const stp_model_desc* desc)
{
    model->source.copy = stp_alloc(model->context, model->source.size);
    if (model->source.copy == NULL) {
        return stp_fail_memory(model->context);
    }
    if (desc->bytes != NULL) {
        memcpy(model->source.copy, desc->bytes, model->source.size);
        return STP_OK;
    }
    return read_blocks(model, desc->name, model->source.copy, model->source.size);
}

/// Reads the directory of a file to be streamed. Opening the store checks the header.
static stp_result read_directory(stp_model* model, const stp_model_desc* desc)
{
    stp_model_source* source = &model->source;
    unsigned char header[STP_STORE_HEADER_BYTES];
    uint64_t end = source->size;
    if (source->size >= sizeof(header)) {
        if (!stp_model_source_read(source, 0, header, sizeof(header))) {
            return fail_read(model, desc->name, 0);
        }
        uint64_t data = stp_read_u64(header + DATA_OFFSET_AT);
        bool is_ours = memcmp(header, STP_STORE_MAGIC, STP_STORE_MAGIC_BYTES) == 0;
        end = is_ours && data <= source->size ? data : sizeof(header);
    }
    if (!stp_reserve(model->context, end)) {
        return stp_fail_memory(model->context);
    }
    source->counted = end;
    void* reserved = mmap(NULL, source->size, PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (reserved == MAP_FAILED) {
        return stp_fail_memory(model->context);
    }
    source->reserved = reserved;
    return read_blocks(model, desc->name, reserved, end);
}

stp_result stp_model_open_source(stp_model* model, const stp_model_desc* desc,
                                 const stp_store_open_desc* opening)
{
    stp_model_source* source = &model->source;
    assert(source->copy == NULL && source->reserved == NULL && "opened once");
    source->read = desc->read;
    source->read_user = desc->read_user;
    source->size = (size_t)desc->size;
    const void* bytes = desc->bytes;
    stp_result result = STP_OK;
    if (desc->size == 0 || desc->size > SIZE_MAX / 2) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT, "%s: its size is not given",
                        desc->name);
    }
    if (bytes == NULL && desc->stream) {
        result = read_directory(model, desc);
        bytes = source->reserved;
    } else if (bytes == NULL || (uintptr_t)bytes % ALIGNMENT != 0) {
        result = copy_bytes(model, desc);
        bytes = source->copy;
    }
    if (result == STP_OK) {
        assert((uintptr_t)bytes % ALIGNMENT == 0 && "columns are used in place");
        result = stp_store_open_memory(model->context, desc->name, bytes, source->size, opening,
                                       &model->store);
    }
    return result;
}

void stp_model_source_destroy(stp_context* context, stp_model_source* source)
{
    stp_free(context, source->copy);
    if (source->reserved != NULL) {
        (void)munmap(source->reserved, source->size);
    }
    assert(source->counted <= source->size && "counts the directory only");
    stp_release(context, source->counted);
    *source = (stp_model_source){0};
}

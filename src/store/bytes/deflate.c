// SPDX-License-Identifier: MIT
#include "store/bytes/deflate.h"

#include <assert.h>
#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>

enum { LEVEL = 6 }; ///< compression level: docs/notes/2026-11-compression.md

stp_store_packer* stp_store_packer_create(void)
{
    return libdeflate_alloc_compressor(LEVEL);
}

void stp_store_packer_destroy(stp_store_packer* packer)
{
    if (packer != NULL) {
        libdeflate_free_compressor(packer);
    }
}

size_t stp_store_pack(stp_store_packer* packer, const void* bytes, size_t size, void* out)
{
    assert(size <= STP_STORE_CHUNK_BYTES);
    size_t minimum = size / STP_STORE_CHUNK_RATIO;
    size_t made = packer != NULL && size > 1
                      ? libdeflate_deflate_compress(packer, bytes, size, out, size - 1)
                      : 0;
    if (made == 0) {
        memcpy(out, bytes, size);
        return size;
    }
    if (made < minimum) { // zero padding: bounds a reader's memory by the file size
        memset((unsigned char*)out + made, 0, minimum - made);
        made = minimum;
    }
    assert(made < size && "a chunk of full size is read as a copy");
    return made;
}

struct stp_store_unpacker {
    struct libdeflate_decompressor* decompressor;
    unsigned char* rooms; ///< NULL: not used yet
};

static stp_store_unpacker* create_unpacker(void)
{
    stp_store_unpacker* made = calloc(1, sizeof(*made));
    if (made == NULL) {
        return NULL;
    }
    made->decompressor = libdeflate_alloc_decompressor();
    if (made->decompressor == NULL) {
        free(made);
        return NULL;
    }
    return made;
}

void stp_store_unpacker_destroy(stp_store_unpacker* unpacker)
{
    if (unpacker != NULL) {
        libdeflate_free_decompressor(unpacker->decompressor);
        free(unpacker->rooms);
        free(unpacker);
    }
}

unsigned char* stp_store_unpacker_rooms(stp_store_unpacker** unpacker)
{
    if (*unpacker == NULL) {
        *unpacker = create_unpacker();
    }
    if (*unpacker != NULL && (*unpacker)->rooms == NULL) {
        (*unpacker)->rooms = malloc(STP_STORE_ROOMS * (size_t)STP_STORE_CHUNK_BYTES);
    }
    return *unpacker != NULL ? (*unpacker)->rooms : NULL;
}

bool stp_store_unpack(stp_store_unpacker** unpacker, const unsigned char* stored,
                      size_t stored_size, void* out, size_t size)
{
    assert(stored_size < size && "a chunk of full size is a copy");
    size_t used = 0, made = 0;
    if (stored_size < size / STP_STORE_CHUNK_RATIO) {
        return false;
    }
    if (*unpacker == NULL) {
        *unpacker = create_unpacker();
    }
    if (*unpacker == NULL ||
        libdeflate_deflate_decompress_ex((*unpacker)->decompressor, stored, stored_size, out, size,
                                         &used, &made) != LIBDEFLATE_SUCCESS) {
        return false;
    }
    for (size_t i = used; i < stored_size; ++i) {
        if (stored[i] != 0) {
            return false;
        }
    }
    return made == size;
}

uint32_t stp_store_crc(uint32_t crc, const void* bytes, size_t size)
{
    return size == 0 ? crc : libdeflate_crc32(crc, bytes, size);
}

// SPDX-License-Identifier: MIT
#include "store/file/texture_images.h"

#include "store/file/block_table.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Limit for the texels of all pictures in a file: at least this many, and more for larger files.
#define TEXELS_ALWAYS_BELIEVED ((uint64_t)1 << 28)
#define TEXELS_PER_BYTE 4096

static stp_store_texture_record* record_of(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_TEXTURES]);
    stp_store_texture_record* records = store->tables[STP_SECTION_TEXTURES];
    return &records[index];
}

static const stp_store_block* block_of(const stp_store* store, uint32_t index)
{
    return stp_store_block_at(store, record_of(store, index)->block);
}

static uint64_t count_texels(const stp_store_texture* texture)
{
    return (uint64_t)texture->width * texture->height;
}

stp_result stp_store_measure_picture(const stp_store_texture* texture, const unsigned char* bytes,
                                     size_t size, stp_image_info* info)
{
    stp_result result = stp_image_measure(bytes, size, info);
    if (result != STP_OK) {
        return result;
    }
    if ((uint32_t)info->kind != texture->encoding) {
        snprintf(info->reason, sizeof(info->reason),
                 "the picture's format differs from its record");
        return STP_ERROR_FORMAT;
    }
    if (info->width != texture->width || info->height != texture->height) {
        snprintf(info->reason, sizeof(info->reason), "the picture has %u x %u texels, not %u x %u",
                 info->width, info->height, texture->width, texture->height);
        return STP_ERROR_FORMAT;
    }
    return STP_OK;
}

/// Whether a file of this size may hold pictures with this many texels in total.
static bool are_plausible(uint64_t texels, uint64_t file_bytes)
{
    return texels <= TEXELS_ALWAYS_BELIEVED || texels / TEXELS_PER_BYTE <= file_bytes;
}

/// An image file of the content; sorted to find equal ones.
typedef struct picture_key {
    stp_hash hash;
    uint32_t texture;
} picture_key;

static int compare_keys(const void* left, const void* right)
{
    const picture_key *a = left, *b = right;
    if (a->hash.high != b->hash.high) {
        return a->hash.high < b->hash.high ? -1 : 1;
    }
    if (a->hash.low != b->hash.low) {
        return a->hash.low < b->hash.low ? -1 : 1;
    }
    return a->texture < b->texture ? -1 : 1;
}

stp_result stp_store_find_texture_owners(stp_context* context, const stp_store_content* content,
                                         uint32_t* owners)
{
    uint32_t count = content->directory.texture_count, pictures = 0;
    picture_key* keys = STP_NEW_ARRAY(context, picture_key, (size_t)count + 1);
    if (keys == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        const stp_store_texture* texture = &content->textures[i];
        owners[i] = i;
        if (texture->encoded != NULL) {
            keys[pictures++] = (picture_key){
                .hash = stp_hash_bytes((stp_hash){0}, texture->encoded, texture->encoded_size),
                .texture = i};
        }
    }
    qsort(keys, pictures, sizeof(*keys), compare_keys);
    for (uint32_t i = 1; i < pictures; ++i) {
        const stp_store_texture *a = &content->textures[keys[i - 1].texture],
                                *b = &content->textures[keys[i].texture];
        if (a->encoded_size == b->encoded_size &&
            memcmp(a->encoded, b->encoded, a->encoded_size) == 0) {
            assert(keys[i - 1].texture < keys[i].texture && "the first one is the owner");
            owners[keys[i].texture] = owners[keys[i - 1].texture];
        }
    }
    stp_free(context, keys);
    return STP_OK;
}

stp_result stp_store_validate_pictures(const stp_store_validator* validator,
                                       const stp_store_content* content)
{
    uint64_t texels = 0, bytes = 0;
    for (uint32_t i = 0; i < content->directory.texture_count; ++i) {
        const stp_store_texture* texture = &content->textures[i];
        stp_image_info info;
        if (texture->encoded == NULL) {
            continue;
        }
        stp_result result =
            stp_store_measure_picture(texture, texture->encoded, texture->encoded_size, &info);
        if (result != STP_OK) {
            return stp_fail(validator->context, validator->failure, "%s: texture %u: %s",
                            validator->path, i, info.reason);
        }
        texels += count_texels(texture);
        bytes += texture->encoded_size;
    }
    return are_plausible(texels, bytes)
               ? STP_OK
               : stp_fail(validator->context, validator->failure,
                          "%s: the pictures claim %llu texels in %llu bytes", validator->path,
                          (unsigned long long)texels, (unsigned long long)bytes);
}

static stp_result fail_texture(const stp_store* store, uint32_t index, const char* fault)
{
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: texture %u: %s", store->path, index,
                    fault);
}

/// A texture has its own block, or shares that of an earlier one with the same picture.
static stp_result link_texture(const stp_store* store, uint32_t index)
{
    stp_store_texture_record* record = record_of(store, index);
    stp_store_texture* texture = &record->texture;
    if (record->block >= store->counts[STP_SECTION_BLOCKS]) {
        return fail_texture(store, index, "its block does not exist");
    }
    const stp_store_block* block = stp_store_block_at(store, record->block);
    if (block->kind != STP_BLOCK_TEXTURE || block->octave != 0 || block->owner > index) {
        return fail_texture(store, index, "its block belongs to another owner");
    }
    if (block->encoding > STP_IMAGE_WEBP) {
        return stp_fail(store->context, STP_ERROR_UNSUPPORTED,
                        "%s: texture %u: its block has the unknown encoding %u", store->path, index,
                        block->encoding);
    }
    const stp_store_texture_record* owner = record_of(store, block->owner);
    bool shares = block->owner != index;
    if (shares &&
        (owner->block != record->block || block->encoding == 0 ||
         owner->texture.width != texture->width || owner->texture.height != texture->height)) {
        return fail_texture(store, index, "its block belongs to another owner");
    }
    if (block->encoding == 0 && block->size != 4 * count_texels(texture)) {
        return fail_texture(store, index, "its block has the wrong size for its counts");
    }
    texture->encoding = block->encoding;
    return STP_OK;
}

stp_result stp_store_link_textures(stp_store* store)
{
    uint64_t texels = 0;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_TEXTURES] && result == STP_OK; ++i) {
        result = link_texture(store, i);
        const stp_store_texture* texture = &record_of(store, i)->texture;
        bool decoded = result == STP_OK && texture->encoding != 0 && block_of(store, i)->owner == i;
        texels += decoded ? count_texels(texture) : 0;
    }
    if (result == STP_OK && !are_plausible(texels, store->file_bytes)) {
        return stp_fail(store->context, STP_ERROR_LIMIT,
                        "%s: the pictures claim %llu texels in a file of %llu bytes", store->path,
                        (unsigned long long)texels, (unsigned long long)store->file_bytes);
    }
    return result;
}

uint32_t stp_store_count_texture_blocks(const stp_store* store)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_TEXTURES]; ++i) {
        count += block_of(store, i)->owner == i ? 1 : 0;
    }
    return count;
}

/// Decodes a picture from a verified block into the caller's memory.
static stp_result decode(const stp_store* store, uint32_t index, const unsigned char* bytes,
                         uint8_t** texels)
{
    const stp_store_texture* texture = &record_of(store, index)->texture;
    size_t size = (size_t)block_of(store, index)->size;
    stp_image_info info;
    stp_image image;
    stp_result result = stp_store_measure_picture(texture, bytes, size, &info);
    if (result == STP_OK) {
        result = stp_image_decode_measured(store->context, bytes, size, &info, &image);
    }
    if (result == STP_ERROR_OUT_OF_MEMORY) {
        return stp_fail_memory(store->context);
    }
    if (result != STP_OK) {
        return fail_texture(store, index, info.reason);
    }
    *texels = image.pixels;
    return STP_OK;
}

stp_result stp_store_load_texture(stp_store* store, uint32_t index, stp_store_texture* texture,
                                  uint8_t** owned)
{
    *owned = NULL;
    if (index >= store->directory.texture_count) {
        return stp_store_fail_index(store, "texture", index);
    }
    const stp_store_texture_record* record = record_of(store, index);
    const stp_store_block* block = block_of(store, index);
    const stp_store_texture_record* owner = record_of(store, block->owner);
    *texture = record->texture;
    if (record->checked) {
        return STP_OK;
    }
    if (owner->decoded != NULL) {
        texture->texels = owner->decoded;
        return STP_OK;
    }
    const unsigned char* bytes = NULL;
    stp_result result = stp_store_verify_block(store, block, &bytes);
    if (result == STP_OK && block->encoding != 0) {
        result = decode(store, index, bytes, owned);
    }
    texture->texels = block->encoding != 0 ? *owned : bytes;
    return result;
}

/// Hands decoded texels (NULL: none) to the store, for all textures that share the block.
static void keep_texels(const stp_store* store, uint32_t index, uint8_t* decoded)
{
    if (decoded != NULL) {
        assert(record_of(store, block_of(store, index)->owner)->decoded == NULL);
        record_of(store, block_of(store, index)->owner)->decoded = decoded;
    }
}

stp_result stp_store_get_texture(stp_store* store, uint32_t index, stp_store_texture* texture)
{
    uint8_t* decoded;
    stp_result result = stp_store_load_texture(store, index, texture, &decoded);
    if (result == STP_OK) {
        stp_store_texture_record* record = record_of(store, index);
        keep_texels(store, index, decoded);
        record->texture.texels = texture->texels;
        record->checked = true;
    }
    return result;
}

typedef struct decode_loop {
    const stp_store* store;
    const uint32_t* textures; ///< each has a different block
    uint8_t** decoded;        ///< NULL: decoding failed
} decode_loop;

static void decode_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const decode_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_store_texture* texture = &record_of(loop->store, loop->textures[i])->texture;
        const stp_store_block* block = block_of(loop->store, loop->textures[i]);
        const unsigned char* bytes = loop->store->file.bytes + block->offset;
        stp_image_info info;
        stp_image image;
        if (stp_store_crc(0, bytes, (size_t)block->size) == block->crc &&
            stp_store_measure_picture(texture, bytes, (size_t)block->size, &info) == STP_OK &&
            stp_image_decode_measured(loop->store->context, bytes, (size_t)block->size, &info,
                                      &image) == STP_OK) {
            loop->decoded[i] = image.pixels;
        }
    }
}

void stp_store_decode_textures(stp_store* store, const uint32_t* textures, size_t count)
{
    stp_context* context = store->context;
    uint32_t* wanted = STP_NEW_ARRAY(context, uint32_t, count + 1);
    uint8_t** decoded = STP_NEW_ZEROED(context, uint8_t*, count + 1);
    uint8_t* listed = STP_NEW_ZEROED(context, uint8_t, (size_t)store->directory.texture_count + 1);
    size_t left = 0;
    for (size_t i = 0; wanted != NULL && decoded != NULL && listed != NULL && i < count; ++i) {
        const stp_store_texture_record* record = record_of(store, textures[i]);
        const stp_store_block* block = block_of(store, textures[i]);
        if (block->encoding != 0 && !record->checked && listed[block->owner] == 0 &&
            record_of(store, block->owner)->decoded == NULL &&
            block->offset + block->size <= store->file.size) {
            listed[block->owner] = 1;
            wanted[left++] = textures[i];
        }
    }
    if (left > 1) { // a single one is decoded on request
        decode_loop loop = {store, wanted, decoded};
        stp_parallel_for(context, left, 1, decode_job, &loop);
        for (size_t i = 0; i < left; ++i) {
            keep_texels(store, wanted[i], decoded[i]);
        }
    }
    stp_free(context, listed);
    stp_free(context, decoded);
    stp_free(context, wanted);
}

void stp_store_release_textures(stp_store* store)
{
    for (uint32_t i = 0; i < store->counts[STP_SECTION_TEXTURES]; ++i) {
        stp_store_texture_record* record = record_of(store, i);
        if (record->texture.encoding != 0) {
            stp_free(store->context, record->decoded);
            record->decoded = NULL;
            record->texture.texels = NULL;
            record->checked = false;
        }
    }
}

const stp_store_texture* stp_store_describe_texture(const stp_store* store, uint32_t index)
{
    return &record_of(store, index)->texture;
}

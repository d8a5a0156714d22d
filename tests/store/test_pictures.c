// SPDX-License-Identifier: MIT
// Textures whose blocks are image files: stored unchanged, shared, decoded on request, never
// trusted.
#include "support_pictures.h"
#include "support_reseal.h"
#include "tests.h"

#include "store/file/block_table.h"
#include "store/residency/residency.h"

#include <string.h>
#include <unistd.h>

enum { SEED = 175 };

/// A file with pictures, in memory.
typedef struct fixture {
    stp_context* context;
    stp_arena arena;
    sample made;
    unsigned char* bytes;
    size_t size;
    stp_store* store;
} fixture;

static bool open_bytes(fixture* f)
{
    return stp_store_open_memory(f->context, "memory", f->bytes, f->size, &(stp_store_open_desc){0},
                                 &f->store) == STP_OK;
}

static bool set_up(fixture* f, stp_context* context, uint32_t large)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_pictures_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    *f = (fixture){.context = context, .arena = stp_arena_create(context, 1 << 16)};
    f->made = sample_make(&f->arena, SEED);
    bool good = f->made.complete && pictures_add(&f->arena, &f->made, large) &&
                stp_store_write(context, &f->made.content, path) == STP_OK;
    f->bytes = good ? sample_read_file(path, &f->size) : NULL;
    unlink(path);
    return f->bytes != NULL && open_bytes(f);
}

static void tear_down(fixture* f)
{
    stp_store_close(f->store);
    free(f->bytes);
    stp_arena_destroy(&f->arena);
}

static const stp_store_block* block_of(const fixture* f, uint32_t texture)
{
    const stp_store_texture_record* records = f->store->tables[STP_SECTION_TEXTURES];
    return stp_store_block_at(f->store, records[texture].block);
}

void test_store_keeps_pictures_as_they_came(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    fixture f;
    CHECK(context != NULL && set_up(&f, context, 1));
    CHECK_EQUAL(2, stp_store_format_minor(f.store));
    for (uint32_t i = 0; i < PICTURE_TEXELS; ++i) {
        const stp_store_texture* texture = &f.made.content.textures[i];
        const stp_store_block* block = block_of(&f, i);
        CHECK_EQUAL(texture->encoding, block->encoding);
        CHECK_EQUAL(texture->encoded_size, block->size);
        CHECK(memcmp(f.bytes + block->offset, texture->encoded, texture->encoded_size) == 0);
    }
    CHECK(block_of(&f, PICTURE_PNG) == block_of(&f, PICTURE_AGAIN)); // one copy
    CHECK_EQUAL(0, block_of(&f, PICTURE_TEXELS)->encoding);
    uint64_t stored = block_of(&f, PICTURE_PNG)->size + block_of(&f, PICTURE_JPEG)->size +
                      block_of(&f, PICTURE_WEBP)->size + block_of(&f, PICTURE_TEXELS)->size;
    CHECK_EQUAL(stored, stp_store_get_summary(f.store)->figures.texture_bytes);
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(f.store, false, &report));
    tear_down(&f);
    stp_context_destroy(context);
}

void test_store_decodes_pictures_once(test_state* test)
{
    stp_context* context = test_context(NULL, 3, NULL);
    fixture f;
    CHECK(context != NULL && set_up(&f, context, 1));
    uint64_t before = stp_context_live_bytes(context);
    const uint32_t all[] = {0, 1, 2, 3, 4};
    stp_store_decode_textures(f.store, all, PICTURE_TEXTURES);
    uint64_t texels = (uint64_t)4 * PICTURE_SIZE * PICTURE_SIZE;
    CHECK(stp_context_live_bytes(context) >= before + 3 * texels); // counted
    CHECK(stp_context_live_bytes(context) < before + 4 * texels);  // the shared one once
    const uint8_t* first = NULL;
    for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
        stp_store_texture texture, again;
        CHECK_EQUAL(STP_OK, stp_store_get_texture(f.store, i, &texture));
        CHECK_EQUAL(STP_OK, stp_store_get_texture(f.store, i, &again));
        CHECK(texture.texels == again.texels);
        CHECK_EQUAL(i % 3, texture.wrap_u);
        CHECK(pictures_error(&texture) <= (i == PICTURE_JPEG ? 8 : 0));
        CHECK(i != PICTURE_AGAIN || texture.texels == first);
        first = texture.texels;
    }
    CHECK(stp_context_live_bytes(context) < before + 4 * texels);
    tear_down(&f);
    // texels that the caller owns leave nothing behind
    CHECK(set_up(&f, context, 1));
    before = stp_context_live_bytes(context);
    for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
        stp_store_texture texture;
        uint8_t* owned;
        CHECK_EQUAL(STP_OK, stp_store_load_texture(f.store, i, &texture, &owned));
        CHECK_EQUAL(i != PICTURE_TEXELS, owned != NULL);
        CHECK(pictures_error(&texture) <= (i == PICTURE_JPEG ? 8 : 0));
        stp_free(context, owned);
    }
    CHECK_EQUAL(before, stp_context_live_bytes(context));
    tear_down(&f);
    stp_context_destroy(context);
}

/// Opens the bytes again and gets a texture. @return the first failure
static stp_result verdict(fixture* f, uint32_t index)
{
    stp_store_texture texture;
    stp_store_close(f->store);
    f->store = NULL;
    stp_result result = stp_store_open_memory(f->context, "memory", f->bytes, f->size,
                                              &(stp_store_open_desc){0}, &f->store);
    return result == STP_OK ? stp_store_get_texture(f->store, index, &texture) : result;
}

void test_store_refuses_damaged_pictures(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    fixture f;
    CHECK(context != NULL && set_up(&f, context, 1));
    for (uint32_t i = 0; i < PICTURE_TEXELS; ++i) {
        uint64_t offset = block_of(&f, i)->offset, size = block_of(&f, i)->size;
        unsigned char* copy = malloc((size_t)size);
        CHECK(copy != NULL);
        memcpy(copy, f.bytes + offset, (size_t)size);
        f.bytes[offset + size / 2] ^= 0x55; // detected by the checksum
        log.errors = 0;
        CHECK_EQUAL(STP_ERROR_FORMAT, verdict(&f, i));
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, "checksum") != NULL);
        // the second half is zero, with valid checksums
        memset(f.bytes + offset + size / 2, 0, (size_t)(size - size / 2));
        reseal(f.bytes, f.size);
        log.errors = 0;
        stp_result result = verdict(&f, i);
        CHECK(result == STP_ERROR_FORMAT || i == PICTURE_WEBP); // WebP may decode zeros
        CHECK_EQUAL(result == STP_OK ? 0 : 1, log.errors);
        // no image at all
        memset(f.bytes + offset, 0, (size_t)size);
        reseal(f.bytes, f.size);
        log.errors = 0;
        CHECK_EQUAL(STP_ERROR_FORMAT, verdict(&f, i));
        CHECK_EQUAL(1, log.errors);
        CHECK(strstr(log.text, "texture") != NULL);
        stp_store_check_report report;
        CHECK(stp_store_check_open(f.store, false, &report) != STP_OK);
        memcpy(f.bytes + offset, copy, (size_t)size);
        reseal(f.bytes, f.size);
        CHECK_EQUAL(STP_OK, verdict(&f, i));
        free(copy);
    }
    tear_down(&f);
    stp_context_destroy(context);
}

/// The bytes of a section.
static unsigned char* section_bytes(unsigned char* bytes, uint32_t type)
{
    unsigned char* entry = find_section(bytes, type);
    return entry != NULL ? bytes + stp_read_u64(entry + 8) : NULL;
}

// Records that do not match their pictures are rejected before anything is allocated.
void test_store_refuses_lies_about_pictures(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    fixture f;
    CHECK(context != NULL && set_up(&f, context, 1));
    unsigned char* records = section_bytes(f.bytes, STP_SECTION_TEXTURES);
    unsigned char* blocks = section_bytes(f.bytes, STP_SECTION_BLOCKS);
    const stp_store_texture_record* known = f.store->tables[STP_SECTION_TEXTURES];
    unsigned char* block = blocks + 40 * (size_t)known[PICTURE_WEBP].block;
    const struct {
        unsigned char* at;
        uint32_t value, texture;
        stp_result wanted;
    } lies[] = {
        {records + 24 * PICTURE_JPEG, 17, PICTURE_JPEG, STP_ERROR_FORMAT},        // its width
        {records + 24 * PICTURE_JPEG + 4, 65536, PICTURE_JPEG, STP_ERROR_FORMAT}, // its height
        {records + 24 * PICTURE_AGAIN, 32, PICTURE_AGAIN,
         STP_ERROR_FORMAT}, // differs from the one it shares
        {records + 24 * PICTURE_PNG + 20, known[PICTURE_JPEG].block, PICTURE_PNG, STP_ERROR_FORMAT},
        {records + 24 * PICTURE_TEXELS + 20, known[PICTURE_JPEG].block, PICTURE_TEXELS,
         STP_ERROR_FORMAT},
        {block + 36, 1, PICTURE_WEBP, STP_ERROR_FORMAT}, // declared as PNG
        {block + 36, 0, PICTURE_WEBP, STP_ERROR_FORMAT}, // declared as texels
        {block + 36, 4, PICTURE_WEBP, STP_ERROR_UNSUPPORTED},
    };
    for (size_t i = 0; i < sizeof(lies) / sizeof(lies[0]); ++i) {
        uint32_t old = stp_read_u32(lies[i].at);
        stp_write_u32(lies[i].at, lies[i].value);
        reseal(f.bytes, f.size);
        log.errors = 0;
        CHECK_EQUAL(lies[i].wanted, verdict(&f, lies[i].texture));
        CHECK_EQUAL(1, log.errors);
        stp_write_u32(lies[i].at, old);
        reseal(f.bytes, f.size);
    }
    // more texels in total than the file may hold
    for (uint32_t i = PICTURE_JPEG; i <= PICTURE_WEBP; ++i) {
        stp_write_u32(records + 24 * i, 65536);
        stp_write_u32(records + 24 * i + 4, 8192);
    }
    reseal(f.bytes, f.size);
    log.errors = 0;
    CHECK_EQUAL(STP_ERROR_LIMIT, verdict(&f, PICTURE_JPEG));
    CHECK_EQUAL(1, log.errors);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_store_refuses_to_write_what_is_no_picture(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample made = sample_make(&arena, SEED);
    CHECK(made.complete && pictures_add(&arena, &made, 1));
    stp_store_texture* texture =
        (stp_store_texture*)(uintptr_t)&made.content.textures[PICTURE_WEBP];
    texture->encoding = 1;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_write(context, &made.content, "/nonexistent/a.stip"));
    CHECK_EQUAL(1, log.errors);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

// Under a limit, reader threads decode pictures into counted memory. A picture that cannot be
// decoded is left out.
void test_store_loads_pictures_within_a_limit(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    fixture f;
    CHECK(context != NULL && set_up(&f, context, 16)); // 256 KiB each, decoded
    stp_data_request wants[PICTURE_TEXTURES];
    for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
        wants[i] =
            (stp_data_request){.kind = STP_RESIDENT_TEXTURE, .index = i, .need = 10.0f - (float)i};
    }
    for (uint64_t limit = 1 << 20; limit <= 4 << 20; limit *= 4) {
        stp_residency* r = NULL;
        stp_residency_desc desc = {.limit_bytes = limit};
        CHECK_EQUAL(STP_OK, stp_residency_create(f.store, &desc, &r));
        do {
            stp_residency_update(r, wants, PICTURE_TEXTURES);
        } while (stp_residency_wait(r));
        uint32_t here = 0;
        for (uint32_t i = 0; i < PICTURE_TEXTURES; ++i) {
            stp_store_texture texture;
            if (stp_store_texture_arrival(f.store, i) != 0) {
                CHECK_EQUAL(STP_OK, stp_store_get_texture(f.store, i, &texture));
                CHECK(pictures_error(&texture) <= (i == PICTURE_JPEG ? 8 : 0));
                here += 1;
            }
        }
        stp_residency_stats stats;
        stp_residency_get_stats(r, &stats);
        CHECK(stats.peak_bytes <= limit);
        CHECK(limit == 1 << 20 ? here >= 1 && here < PICTURE_TEXTURES : here == PICTURE_TEXTURES);
        CHECK_EQUAL(0, stats.damaged);
        stp_residency_destroy(r);
    }
    uint64_t offset = block_of(&f, PICTURE_PNG)->offset;
    memset(f.bytes + offset, 0, 64);
    reseal(f.bytes, f.size);
    stp_store_close(f.store);
    f.store = NULL;
    CHECK(open_bytes(&f));
    stp_residency* r = NULL;
    CHECK_EQUAL(STP_OK, stp_residency_create(f.store, &(stp_residency_desc){0}, &r));
    do {
        stp_residency_update(r, wants, 1);
    } while (stp_residency_wait(r));
    CHECK_EQUAL(0, stp_store_texture_arrival(f.store, PICTURE_PNG));
    CHECK_EQUAL(1, log.warnings);
    CHECK(strstr(log.warning, "texture 0") != NULL);
    stp_residency_destroy(r);
    tear_down(&f);
    stp_context_destroy(context);
}

void test_store_decodes_pictures_without_memory(test_state* test)
{
    for (int fail_at = 0, done = 0; !done; ++fail_at) {
        stp_context* context = test_context(NULL, 2, NULL);
        fixture f;
        CHECK(context != NULL && set_up(&f, context, 1));
        test_heap heap = TEST_HEAP(fail_at + 3); // the context's own allocations
        stp_context* poor = test_context(&heap, 2, NULL);
        if (poor != NULL) {
            stp_store* store = NULL;
            stp_result result = stp_store_open_memory(poor, "memory", f.bytes, f.size,
                                                      &(stp_store_open_desc){0}, &store);
            const uint32_t all[] = {0, 1, 2, 3, 4};
            if (result == STP_OK) {
                stp_store_decode_textures(store, all, PICTURE_TEXTURES);
            }
            for (uint32_t i = 0; i < PICTURE_TEXTURES && result == STP_OK; ++i) {
                stp_store_texture texture;
                result = stp_store_get_texture(store, i, &texture);
            }
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            done = heap.count <= heap.fail_at;
            stp_store_close(store);
            stp_context_destroy(poor);
        }
        tear_down(&f);
        stp_context_destroy(context);
    }
}

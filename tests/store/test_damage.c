// SPDX-License-Identifier: MIT
// Files that are truncated, changed, forged, or from a later version.
#include "exhaustive.h"
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "store/bytes/format.h"

#include <string.h>
#include <unistd.h>

#define GOLDEN STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample-1.2.stip"
#define GOLDEN_PACKED STP_TEST_SOURCE_DIR "/tests/golden/store/v1/packed-1.2.stip"
#define GOLDEN_1_0 STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample.stip"

static const stp_store_open_desc whole = {0};

static void check_truncations(test_state* test, const char* path)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(bytes != NULL && context != NULL);
    for (size_t length = 0; length < size; ++length) {
        void* copy = NULL;
        CHECK(posix_memalign(&copy, 64, length) ==
              0); // exactly the file's size, so that sanitizers detect reads beyond it
        memcpy(copy, bytes, length);
        log.errors = 0;
        stp_result result = sample_check(context, copy, length);
        free(copy);
        CHECK_EQUAL(STP_ERROR_TRUNCATED, result);
        CHECK_EQUAL(1, log.errors);
    }
    CHECK_EQUAL(STP_OK, sample_check(context, bytes, size));
    free(bytes);
    stp_context_destroy(context);
}

void test_store_refuses_every_truncation(test_state* test)
{
    check_truncations(test, GOLDEN);
    check_truncations(test, GOLDEN_PACKED);
}

static void check_changed_bytes(test_state* test, const char* path)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(bytes != NULL && context != NULL);
    for (size_t at = 0; at < size; ++at) {
        // all changes of the header and of the sections' records, then one of each byte
        size_t stride = at < 1024 ? 1 : test_stride(9);
        for (size_t bit = stride == 1 ? 0 : at % 9; bit < 9; bit += stride) {
            unsigned char old = bytes[at];
            bytes[at] = (unsigned char)(old ^ (bit < 8 ? 1u << bit : 0xFFu));
            log.errors = 0;
            stp_result result = sample_check(context, bytes, size);
            bytes[at] = old;
            if (result == STP_OK || log.errors != 1) {
                fprintf(stderr, "byte %zu, bit %zu: %s\n", at, bit, stp_result_string(result));
            }
            CHECK(result != STP_OK);
            CHECK_EQUAL(1, log.errors);
        }
    }
    free(bytes);
    stp_context_destroy(context);
}

void test_store_refuses_every_changed_byte(test_state* test)
{
    check_changed_bytes(test, GOLDEN);
    check_changed_bytes(test, GOLDEN_PACKED);
}

void test_store_names_the_defect(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(GOLDEN, &size);
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(bytes != NULL && context != NULL);
    bytes[5] = '\r'; // \r\n -> \r\r: a transfer that converted line ends
    CHECK_EQUAL(STP_ERROR_FORMAT, sample_check(context, bytes, size));
    CHECK(strstr(log.text, "line ends") != NULL);
    memcpy(bytes, "ply\n", 4);
    CHECK_EQUAL(STP_ERROR_FORMAT, sample_check(context, bytes, size));
    CHECK(strstr(log.text, "not a .stip file") != NULL);
    memcpy(bytes, STP_STORE_MAGIC, 8);
    bytes[size - 1] ^= 1;
    CHECK_EQUAL(STP_ERROR_FORMAT, sample_check(context, bytes, size));
    CHECK(strstr(log.text, "checksum of the block") != NULL);
    free(bytes);
    stp_context_destroy(context);
}

// A section table beyond the data, or beyond the limit, is refused before it is read.
void test_store_refuses_section_tables_that_do_not_fit(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(GOLDEN, &size);
    CHECK(bytes != NULL);
    uint32_t data = (uint32_t)stp_read_u64(bytes + 24);
    uint32_t fits = (data - STP_STORE_HEADER_BYTES) / STP_STORE_SECTION_BYTES;
    const uint32_t counts[] = {fits + 1, fits + 2, STP_STORE_SECTION_LIMIT + 1, UINT32_MAX};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); ++i) {
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_write_u32(bytes + 32, counts[i]);
        stp_write_u32(bytes + 36, reseal_crc(bytes, size, STP_STORE_HEADER_BYTES,
                                             (uint64_t)counts[i] * STP_STORE_SECTION_BYTES));
        stp_write_u32(bytes + 124, reseal_crc(bytes, size, 0, 124));
        CHECK_EQUAL(STP_ERROR_FORMAT, sample_check(context, bytes, size));
        CHECK(strstr(log.text, "the section table does not fit before the data") != NULL);
        stp_context_destroy(context);
    }
    free(bytes);
}

void test_store_opens_newer_minor_versions(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(GOLDEN_1_0, &size);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(bytes != NULL && context != NULL);
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &whole, &store));
    uint32_t objects = stp_store_get_directory(store)->object_count;
    uint32_t views = stp_store_get_directory(store)->view_count;
    stp_store_close(store);
    CHECK(objects > 1 && views > 0);

    // a newer minor version, with an unknown section type in place of the views
    stp_write_u16(bytes + 10, 7);
    stp_write_u32(find_section(bytes, STP_SECTION_VIEWS), 99);
    reseal(bytes, size);
    CHECK_EQUAL(STP_OK, sample_check(context, bytes, size));
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &whole, &store));
    CHECK_EQUAL(0, stp_store_get_directory(store)->view_count);
    stp_store_close(store);

    // the same, critical
    stp_write_u32(find_section(bytes, 99) + 4, STP_SECTION_CRITICAL);
    reseal(bytes, size);
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, sample_check(context, bytes, size));
    stp_write_u32(find_section(bytes, 99) + 4, 0);

    // records with fields appended: one object that is as long as all
    unsigned char* entry = find_section(bytes, STP_SECTION_OBJECTS);
    stp_write_u64(entry + 24, 1);
    stp_write_u32(entry + 32, 112 * objects);
    reseal(bytes, size);
    CHECK_EQUAL(STP_OK, sample_check(context, bytes, size));
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &whole, &store));
    CHECK_EQUAL(1, stp_store_get_directory(store)->object_count);
    stp_store_close(store);

    // a newer major version is rejected as such, whatever its header contains
    stp_write_u16(bytes + 8, STP_STORE_MAJOR + 1);
    memset(bytes + 60, 0xAB, 64);
    CHECK_EQUAL(STP_ERROR_VERSION, sample_check(context, bytes, size));
    free(bytes);
    stp_context_destroy(context);
}

// Replaces every 32-bit word of header, section table and tables by misleading numbers and reseals
// the checksums. In all cases nothing is read out of bounds and memory stays bounded.
static void check_forged_numbers(test_state* test, const char* path)
{
    static const uint32_t forged[] = {0,          1,       0x7FFFFFFF, 0xFFFFFFFE,
                                      0xFFFFFFFF, 0x10000, 0x7F800000};
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    CHECK(bytes != NULL);
    void* copy = NULL;
    CHECK(posix_memalign(&copy, 64, size) == 0);
    uint64_t data_offset = stp_read_u64(bytes + 24);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    int refused = 0;
    for (size_t at = 8; at + 4 <= data_offset; at += 4) {
        for (size_t i = 0; i < sizeof(forged) / sizeof(forged[0]); ++i) {
            memcpy(copy, bytes, size);
            stp_write_u32((unsigned char*)copy + at, forged[i]);
            reseal(copy, size);
            refused += sample_check(context, copy, size) != STP_OK;
        }
    }
    CHECK(refused > 1000);
    CHECK(stp_context_peak_bytes(context) < 40 * size);
    free(copy);
    free(bytes);
    stp_context_destroy(context);
}

void test_store_survives_forged_numbers(test_state* test)
{
    check_forged_numbers(test, GOLDEN);
    check_forged_numbers(test, GOLDEN_PACKED);
}

static void check_prefixes(test_state* test, const char* path)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(bytes != NULL && context != NULL);
    stp_store* full = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "full", bytes, size, &whole, &full));
    uint32_t sets = stp_store_get_directory(full)->set_count;
    CHECK(sets > 0);
    stp_store_open_desc desc = {.accept_partial = true};
    uint32_t octaves_before = 0;
    for (size_t length = 0; length <= size; ++length) {
        void* copy = NULL;
        CHECK(posix_memalign(&copy, 64, length) == 0);
        memcpy(copy, bytes, length);
        stp_store* store = NULL;
        stp_result opened = stp_store_open_memory(context, "cut", copy, length, &desc, &store);
        CHECK_EQUAL(length < stp_read_u64(bytes + 24) ? STP_ERROR_TRUNCATED : STP_OK, opened);
        uint32_t octaves = 0;
        for (uint32_t i = 0; opened == STP_OK && i < sets; ++i) {
            stp_splats cut, wanted;
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, i, &cut));
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(full, i, cut.octave_count, &wanted));
            CHECK_EQUAL(wanted.count, cut.count);
            size_t entries = 0;
            for (uint32_t k = 0; k < cut.octave_count; ++k) {
                entries += cut.octave_ends[k];
            }
            CHECK(cut.count == 0 ||
                  (memcmp(wanted.positions, cut.positions, 6 * (size_t)cut.count) == 0 &&
                   memcmp(wanted.normals, cut.normals, 2 * (size_t)cut.count) == 0 &&
                   memcmp(wanted.materials, cut.materials, cut.count) == 0 &&
                   memcmp(wanted.colors, cut.colors, 3 * entries) == 0 &&
                   memcmp(wanted.coverages, cut.coverages, entries) == 0));
            CHECK(cut.table.size == 0 || cut.table.count[cut.table.size - 1] <= cut.count);
            octaves += cut.octave_count;
        }
        CHECK(octaves >= octaves_before); // more bytes, never fewer splats
        octaves_before = octaves;
        stp_store_close(store);
        free(copy);
    }
    uint32_t all = 0;
    for (uint32_t i = 0; i < sets; ++i) {
        all += stp_store_describe_splat_set(full, i)->octave_count;
    }
    CHECK_EQUAL(all, octaves_before);
    stp_store_close(full);
    free(bytes);
    stp_context_destroy(context);
}

void test_store_reads_every_prefix_that_holds_the_directory(test_state* test)
{
    check_prefixes(test, GOLDEN);
    check_prefixes(test, GOLDEN_PACKED);
}

// A scene of one mesh whose block has a gap: positions at 0 to 11, gap, indices at 16 to 27.
static unsigned char* make_gap(stp_context* context, size_t* size)
{
    char path[256];
    const char* folder = getenv("TMPDIR");
    snprintf(path, sizeof(path), "%s/stp_gap_%ld.stip", folder != NULL ? folder : "/tmp",
             (long)getpid());
    float position[3] = {1.0f, 2.0f, 3.0f};
    uint32_t indices[3] = {0, 0, 0};
    stp_store_mesh mesh = {
        .vertex_count = 1, .triangle_count = 1, .positions = position, .indices = indices};
    stp_store_material material = {
        .base_color_texture.texture = STP_STORE_NONE,
        .metallic_roughness_texture.texture = STP_STORE_NONE,
        .emissive_texture.texture = STP_STORE_NONE,
    };
    stp_store_content content = {
        .directory = {.root = STP_STORE_NONE,
                      .mesh_count = 1,
                      .material_count = 1,
                      .materials = &material,
                      .up = 'y'},
        .meshes = &mesh,
    };
    unsigned char* bytes = NULL;
    if (stp_store_write(context, &content, path) == STP_OK) {
        bytes = sample_read_file(path, size);
    }
    unlink(path);
    return bytes;
}

void test_store_checks_bytes_between_columns(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = make_gap(context, &size);
    CHECK(bytes != NULL);
    CHECK_EQUAL(STP_OK, sample_check(context, bytes, size));
    CHECK_EQUAL(28, size - stp_read_u64(bytes + 24));
    bytes[size - 28 + 13] = 1;
    reseal(bytes, size);
    CHECK_EQUAL(STP_ERROR_FORMAT, sample_check(context, bytes, size));
    CHECK(strstr(log.text, "between blocks or columns") != NULL);
    free(bytes);
    stp_context_destroy(context);
}

// Other fields of view cannot be drawn.
void test_store_checks_the_angles_of_views(test_state* test)
{
    static const struct {
        double degrees;
        stp_result result;
    } cases[] = {{0.001, STP_OK},
                 {179.9, STP_OK},
                 {1e-160, STP_ERROR_FORMAT},
                 {0.0, STP_ERROR_FORMAT},
                 {179.95, STP_ERROR_FORMAT}};
    test_log log = {.errors = 0};
    size_t size = 0;
    unsigned char* bytes = sample_read_file(GOLDEN_1_0, &size);
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(bytes != NULL && context != NULL);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_store_section views = reseal_section(find_section(bytes, STP_SECTION_VIEWS));
        memcpy(bytes + views.offset + 80, &cases[i].degrees, sizeof(double));
        reseal(bytes, size);
        CHECK_EQUAL(cases[i].result, sample_check(context, bytes, size));
        CHECK(cases[i].result == STP_OK || strstr(log.text, "view 0 has a field of view") != NULL);
    }
    free(bytes);
    stp_context_destroy(context);
}

void test_store_keeps_damaged_data_away_from_callers(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = make_gap(context, &size);
    CHECK(bytes != NULL);
    for (int sealed = 0; sealed < 2; ++sealed) {
        stp_store* store = NULL;
        stp_store_mesh mesh;
        bytes[size - 1] = 7; // an index of 7 << 24, first with a wrong checksum, then resealed
        if (sealed == 1) {
            reseal(bytes, size);
        }
        CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "m", bytes, size, &whole, &store));
        log.errors = 0;
        for (int again = 0; again < 2; ++again) {
            CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_get_mesh(store, 0, &mesh));
            CHECK_EQUAL(again + 1, log.errors);
            CHECK(strstr(log.text, sealed == 1 ? "vertex count" : "checksum") != NULL);
        }
        CHECK(stp_store_describe_mesh(store, 0)->indices == NULL);
        stp_store_close(store);
    }
    free(bytes);
    stp_context_destroy(context);
}

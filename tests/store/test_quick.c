// SPDX-License-Identifier: MIT
// What describing and quickly checking a file of any size reads, and what it detects.
#define _DEFAULT_SOURCE // mincore
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { NODES = 12000, NAMES = 60000 };

static void temporary_path(char path[256], const char* name)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp_%s_%ld.stip", folder != NULL ? folder : "/tmp", name,
             (long)getpid());
}

// A scene of many nodes and objects, materials with long names, two views, a source, and one
// texture. `packed`: with a packed directory where that is smaller.
static bool write_large(stp_context* context, const char* path, bool packed)
{
    stp_arena arena = stp_arena_create(context, 1 << 20);
    stp_store_node* nodes = STP_ARENA_ARRAY(&arena, stp_store_node, NODES);
    stp_store_edge* edges = STP_ARENA_ARRAY(&arena, stp_store_edge, NODES);
    stp_store_object* objects = STP_ARENA_ARRAY(&arena, stp_store_object, NAMES);
    stp_store_material* materials = STP_ARENA_ARRAY(&arena, stp_store_material, NODES);
    if (nodes == NULL || edges == NULL || objects == NULL || materials == NULL) {
        stp_arena_destroy(&arena);
        return false;
    }
    static const char* const name = "a name that is rather long, as those of materials and parts "
                                    "in real models are, so that texts are many pages";
    const stp_store_texture_use unused = {.texture = STP_STORE_NONE};
    for (uint32_t i = 0; i < NODES; ++i) {
        nodes[i] = (stp_store_node){
            .first_edge = i, .edge_count = i > 0, .set = STP_STORE_NONE, .flags = i % 2};
        edges[i] = (stp_store_edge){.node = i > 0 ? i - 1 : 0, .transform = stp_affine_identity()};
        materials[i] = (stp_store_material){.name = name,
                                            .base_color_texture = unused,
                                            .metallic_roughness_texture = unused,
                                            .emissive_texture = unused};
    }
    for (uint32_t i = 0; i < NAMES; ++i) {
        objects[i] = (stp_store_object){.name = name,
                                        .parent = i > 0 ? i % 10 : STP_STORE_NONE,
                                        .node = i % NODES,
                                        .transform = stp_affine_identity()};
        objects[i].parent = i > 0 && i < 10 ? 0 : objects[i].parent;
    }
    uint8_t texel[4] = {1, 2, 3, 4};
    stp_store_texture texture = {.width = 1, .height = 1, .texels = texel};
    stp_store_view views[2] = {{.name = "first", .fov_degrees = 50.0},
                               {.name = "second", .fov_degrees = 60.0}};
    stp_store_source source = {"model.glb", "gltf", 123, NULL};
    stp_store_content content = {.directory = {.root = NODES - 1,
                                               .node_count = NODES,
                                               .nodes = nodes,
                                               .edge_count = NODES,
                                               .edges = edges,
                                               .object_count = NAMES,
                                               .objects = objects,
                                               .material_count = NODES,
                                               .materials = materials,
                                               .texture_count = 1,
                                               .view_count = 2,
                                               .views = views,
                                               .source_count = 1,
                                               .sources = &source,
                                               .up = 'z',
                                               .build_json = "{\"method\": \"blue\"}"},
                                 .textures = &texture,
                                 .passing = !packed};
    nodes[0].edge_count = 0;
    bool written = stp_store_write(context, &content, path) == STP_OK;
    stp_arena_destroy(&arena);
    return written;
}

// Enlarges the texture, and so the file, to 10 GiB: everything but the directory is a hole.
static uint64_t grow_file(const char* path)
{
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    if (bytes == NULL) {
        return 0;
    }
    uint64_t texels = (uint64_t)65536 * 40960, data_offset = stp_read_u64(bytes + 24);
    unsigned char* textures = bytes + stp_read_u64(find_section(bytes, STP_SECTION_TEXTURES) + 8);
    unsigned char* blocks = bytes + stp_read_u64(find_section(bytes, STP_SECTION_BLOCKS) + 8);
    stp_write_u32(textures, 65536);
    stp_write_u32(textures + 4, 40960);
    stp_write_u64(blocks + 24, 4 * texels);
    stp_write_u64(bytes + 16, data_offset + 4 * texels);
    reseal(bytes, size);
    FILE* file = fopen(path, "wb");
    bool written = file != NULL && fwrite(bytes, 1, data_offset, file) == data_offset;
    written = file != NULL && fclose(file) == 0 && written;
    free(bytes);
    return written && truncate(path, (off_t)(data_offset + 4 * texels)) == 0
               ? data_offset + 4 * texels
               : 0;
}

// Evicts a file from the page cache, so that cached pages show later reads. @return whether that
// worked
static uint64_t cached_bytes(const char* path, uint64_t size, bool drop)
{
    int file = open(path, O_RDONLY);
    if (file < 0) {
        return UINT64_MAX;
    }
    if (drop) {
        (void)fsync(file);
        (void)posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    }
    size_t page = (size_t)sysconf(_SC_PAGESIZE), pages = (size_t)(size / page) + 1;
    unsigned char* in_memory = malloc(pages);
    void* map = mmap(NULL, (size_t)size, PROT_READ, MAP_SHARED, file, 0);
    uint64_t sum = UINT64_MAX;
    if (in_memory != NULL && map != MAP_FAILED && mincore(map, (size_t)size, in_memory) == 0) {
        sum = 0;
        for (size_t i = 0; i < pages - 1; ++i) {
            sum += (in_memory[i] & 1) != 0 ? page : 0;
        }
    }
    if (map != MAP_FAILED) {
        munmap(map, (size_t)size);
    }
    free(in_memory);
    close(file);
    return sum;
}

void test_store_describes_10_gb_from_less_than_1_mb(test_state* test)
{
    char path[256];
    temporary_path(path, "huge");
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    CHECK(write_large(context, path, false));
    uint64_t size = grow_file(path);
    if (size == 0) {
        unlink(path);
        stp_context_destroy(context);
        SKIP("the file system has no files of 10 GB");
    }
    uint64_t described = 0, checked = 0, before = cached_bytes(path, size, true);
    bool measured = before == 0;
    stp_store* store = NULL;
    stp_store_open_desc desc = {.summary_only = true};
    CHECK_EQUAL(STP_OK, stp_store_open_with(context, path, &desc, &store));
    described = cached_bytes(path, size, false);
    const stp_store_summary* summary = stp_store_get_summary(store);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK(summary != NULL && summary->figures.unique_nodes == NODES);
    CHECK(summary->part_count == 65 && strcmp(summary->parts[64].name, "others") == 0);
    CHECK(d->view_count == 2 && strcmp(d->views[1].name, "second") == 0);
    CHECK(strcmp(d->sources[0].path, "model.glb") == 0 && d->up == 'z');
    CHECK(strcmp(d->build_json, "{\"method\": \"blue\"}") == 0);
    CHECK_EQUAL(size, stp_store_file_bytes(store));
    stp_store_close(store);
    (void)cached_bytes(path, size, true);
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_with_report(context, path, true, &report));
    checked = cached_bytes(path, size, false);
    unlink(path);
    stp_context_destroy(context);
    CHECK(size > UINT64_C(10) << 30);
    CHECK(report.bytes_checked < 1 << 20 && report.bytes_checked > 1 << 16);
    CHECK_EQUAL(size, report.file_bytes);
    CHECK_EQUAL(1, report.blocks);
    if (!measured) {
        SKIP("the system does not say what of a file is in memory");
    }
    if (described >= 1 << 19 || checked >= 1 << 20) {
        fprintf(stderr, "read %llu and %llu bytes\n", (unsigned long long)described,
                (unsigned long long)checked);
    }
    CHECK(described > 0 && described < 1 << 19);
    CHECK(checked > described && checked < 1 << 20);
}

static stp_result check_quickly(stp_context* context, const unsigned char* bytes, size_t size)
{
    stp_store* store = NULL;
    stp_store_check_report report;
    stp_store_open_desc desc = {.summary_only = true};
    stp_result result = stp_store_open_memory(context, "memory", bytes, size, &desc, &store);
    if (result == STP_OK) {
        result = stp_store_check_open(store, true, &report);
        stp_store_close(store);
    }
    return result;
}

// Changes each byte that a quick check covers: one in `stride`, and the ends.
static int count_missed(stp_context* context, unsigned char* bytes, size_t size, uint64_t begin,
                        uint64_t length, uint64_t stride)
{
    int missed = 0;
    for (uint64_t i = 0; i < length; i += stride) {
        uint64_t at = begin + (i + stride < length ? i : length - 1);
        bytes[at] ^= 0x10;
        missed += check_quickly(context, bytes, size) == STP_OK;
        bytes[at] ^= 0x10;
    }
    return missed;
}

// Pages of a packed section.
static uint64_t packed_pages(const unsigned char* entry)
{
    stp_store_section section = reseal_section(entry);
    return stp_store_packed_page_count(&section);
}

static void check_promise(test_state* test, bool pack)
{
    char path[256];
    temporary_path(path, "promise");
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    CHECK(write_large(context, path, pack));
    size_t size = 0;
    unsigned char* bytes = sample_read_file(path, &size);
    unlink(path);
    CHECK(bytes != NULL);
    CHECK_EQUAL(STP_OK, check_quickly(context, bytes, size));
    // header and section table: all bytes
    uint64_t table = STP_STORE_HEADER_BYTES + 40 * (uint64_t)stp_read_u32(bytes + 32);
    CHECK_EQUAL(0, count_missed(context, bytes, size, 0, table, 3));
    static const uint32_t whole[] = {STP_SECTION_SUMMARY, STP_SECTION_SCENE_PARTS,
                                     STP_SECTION_VIEWS,   STP_SECTION_SOURCES,
                                     STP_SECTION_BUILD,   STP_SECTION_PAGES};
    for (size_t i = 0; i < sizeof(whole) / sizeof(whole[0]); ++i) {
        const unsigned char* entry = find_section(bytes, whole[i]);
        uint64_t length = stp_read_u64(entry + 16);
        CHECK(length > 0);
        CHECK_EQUAL(0, count_missed(context, bytes, size, stp_read_u64(entry + 8), length,
                                    1 + length / 40));
    }
    // other sections: the first page and the padding before it
    int large = 0, packed = 0;
    for (uint32_t i = 0; i < stp_read_u32(bytes + 32); ++i) {
        const unsigned char* entry = bytes + STP_STORE_HEADER_BYTES + 40 * (size_t)i;
        uint64_t offset = stp_read_u64(entry + 8), length = stp_read_u64(entry + 16);
        uint64_t page = length < STP_STORE_PAGE_BYTES ? length : STP_STORE_PAGE_BYTES;
        if ((stp_read_u32(entry + 4) & STP_SECTION_PACKED) != 0) { // the table of pages, and a page
            packed += 1;
            page = stp_read_u32(bytes + offset) + STP_STORE_CHUNK_ENTRY * packed_pages(entry);
        }
        CHECK_EQUAL(0, count_missed(context, bytes, size, offset, page, 1 + page / 40));
        if (length > page && stp_read_u32(entry) != STP_SECTION_PAGES) {
            bytes[offset + length - 1] ^= 1; // covered by a full check, but not by a quick one
            large += check_quickly(context, bytes, size) == STP_OK;
            stp_store* store = NULL;
            stp_store_open_desc desc = {.defer_objects = true};
            stp_result result = stp_store_open_memory(context, "m", bytes, size, &desc, &store);
            stp_store_check_report report;
            if (result == STP_OK) {
                result = stp_store_check_open(store, true, &report);
                stp_store_close(store);
            }
            CHECK_EQUAL(STP_ERROR_FORMAT, result);
            bytes[offset + length - 1] ^= 1;
        }
    }
    CHECK(large >= 5 && (pack ? packed >= 5 : packed == 0));
    // a partial file
    CHECK_EQUAL(STP_ERROR_TRUNCATED, check_quickly(context, bytes, size - 1));
    // texts of views and sources, on their pages
    const unsigned char* text = find_section(bytes, STP_SECTION_TEXT);
    uint64_t texts =
        stp_read_u64(text + 8) + (pack ? STP_STORE_CHUNK_ENTRY * packed_pages(text) : 0);
    log.errors = 0;
    bytes[texts + 3] ^= 1;
    CHECK_EQUAL(STP_ERROR_FORMAT, check_quickly(context, bytes, size));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "checksum of page 0 of the section of type 15") != NULL);
    free(bytes);
    stp_context_destroy(context);
}

void test_store_quick_check_keeps_its_promise(test_state* test)
{
    check_promise(test, false);
    check_promise(test, true);
}

// A summary that contradicts the file, with valid checksums.
void test_store_check_finds_wrong_summaries(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes =
        sample_read_file(STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample-1.1.stip", &size);
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(bytes != NULL && context != NULL);
    uint64_t summary = stp_read_u64(find_section(bytes, STP_SECTION_SUMMARY) + 8);
    for (uint32_t i = 0; i < 50; ++i) {
        unsigned char* field = bytes + summary + 4 * (size_t)i;
        stp_write_u32(field, stp_read_u32(field) ^ 1);
        reseal(bytes, size);
        stp_store* store = NULL;
        stp_store_open_desc desc = {.defer_objects = true};
        stp_result result = stp_store_open_memory(context, "m", bytes, size, &desc, &store);
        CHECK_EQUAL(STP_OK, result);
        stp_store_check_report report;
        result = stp_store_check_open(store, false, &report);
        stp_store_close(store);
        // the first three numbers are stored only, not computed
        bool accepted = i < 6;
        if (accepted != (result == STP_OK)) {
            fprintf(stderr, "word %u: %s\n", i, stp_result_string(result));
        }
        CHECK_EQUAL(accepted ? STP_OK : STP_ERROR_FORMAT, result);
        stp_write_u32(field, stp_read_u32(field) ^ 1);
    }
    free(bytes);
    stp_context_destroy(context);
}

void test_store_head_survives_failing_allocator(test_state* test)
{
    const char* path = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/sample-1.1.stip";
    bool done = false;
    for (int n = 0; !done && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context != NULL) {
            stp_store *head = NULL, *store = NULL;
            stp_store_open_desc desc = {.summary_only = true};
            stp_result result = stp_store_open_with(context, path, &desc, &head);
            stp_store_check_report report;
            result = result == STP_OK ? stp_store_check_open(head, true, &report) : result;
            result = result == STP_OK ? stp_store_open(context, path, &store) : result;
            stp_store_stored_splat_set splats;
            stp_store_stored_mesh mesh;
            stp_store_summary summary = {0};
            if (result == STP_OK) {
                result = stp_store_find_splat_set_by_key(store, (stp_hash){1, 2}, &splats);
            }
            if (result == STP_OK) {
                result = stp_store_find_mesh_by_key(store, (stp_hash){1, 2}, &mesh);
            }
            result = result == STP_OK ? stp_store_summarise(store, &summary) : result;
            stp_store_summary_destroy(context, &summary);
            stp_store_close(head);
            stp_store_close(store);
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            CHECK_EQUAL(result != STP_OK, log.errors);
            done = result == STP_OK;
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
}

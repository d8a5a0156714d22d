// SPDX-License-Identifier: MIT
//
// PLY files whose points are large compared to the memory limit: they go to the scene's spill file
// while they are read, and the result is the same.
#include "spilled_import.h"

enum { POINTS = 40000, ROW = 33, HEAD = 512, STRIDE = 4096 };

// A binary file in pages of its own, like a mapping.
static unsigned char* write_points(size_t* size)
{
    size_t whole = (HEAD + (size_t)POINTS * ROW + STRIDE - 1) / STRIDE * STRIDE;
    unsigned char* bytes = aligned_alloc(STRIDE, whole);
    if (bytes == NULL) {
        return NULL;
    }
    size_t at = (size_t)snprintf((char*)bytes, HEAD,
                                 "ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
                                 "property float x\nproperty float y\nproperty float z\n"
                                 "property float nx\nproperty float ny\nproperty float nz\n"
                                 "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                                 "property float intensity\nproperty ushort source\n"
                                 "end_header\n",
                                 POINTS);
    for (int i = 0; i < POINTS; ++i, at += ROW) {
        float row[6] = {
            (float)(i % 200), (float)(i / 200), (float)(i % 7), (float)(i % 3), 1.0f, 0.5f};
        row[i % 5] = i % 1000 == 7 ? (float)NAN : row[i % 5]; // some are skipped
        memcpy(bytes + at, row, sizeof(row));
        memset(bytes + at + sizeof(row), i % 251, 3);
        float intensity = (float)(i % 65536);
        memcpy(bytes + at + sizeof(row) + 3, &intensity, sizeof(intensity));
        memset(bytes + at + sizeof(row) + 7, i % 13, 2);
    }
    *size = at;
    return bytes;
}

static stp_result read_points(stp_context* context, stp_scene* scene, const void* bytes,
                              size_t size)
{
    (void)context;
    stp_result result = stp_import_memory(scene, "a.ply", bytes, size, &(stp_import_desc){0});
    return result == STP_OK ? stp_scene_finish(scene) : result;
}

void test_ply_spilled_points_change_nothing_but_memory(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = write_points(&size);
    CHECK(bytes != NULL);
    spilled_import plain = {0};
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        for (int spills = 0; spills < 2; ++spills) {
            stp_context* context = test_context(NULL, threads, NULL);
            spilled_import now = import_spilled(context, read_points, bytes, size, spills == 1);
            CHECK_EQUAL(STP_OK, now.result);
            CHECK_EQUAL(spills, now.spilled);
            plain = threads == 1 && spills == 0 ? now : plain;
            CHECK(stp_hash_equal(now.digest, plain.digest));
            CHECK(spills == 0 || 10 * now.peak_bytes < plain.peak_bytes);
            CHECK_EQUAL(0, now.left_bytes);
            stp_context_destroy(context);
        }
    }
    free(bytes);
}

void test_ply_spilled_points_survive_failing_allocator(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = write_points(&size);
    CHECK(bytes != NULL);
    bool made = false;
    for (int n = 1; !made && n < 1000; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            spilled_import now = import_spilled(context, read_points, bytes, size, true);
            made = now.result == STP_OK && heap.count <= n;
            CHECK(now.result == STP_OK || now.result == STP_ERROR_OUT_OF_MEMORY);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
    free(bytes);
}

void test_ply_spilled_points_say_that_the_disk_is_full(test_state* test)
{
    size_t size = 0;
    unsigned char* bytes = write_points(&size);
    CHECK(bytes != NULL);
    test_log log = {0};
    stp_context* context = test_context(NULL, 2, &log);
    file_limit limit;
    CHECK(file_limit_begin(&limit, 1 << 20));
    spilled_import now = import_spilled(context, read_points, bytes, size, true);
    file_limit_end(&limit);
    CHECK_EQUAL(STP_ERROR_IO, now.result);
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "no room for") != NULL);
    CHECK_EQUAL(0, now.left_bytes);
    stp_context_destroy(context);
    free(bytes);
}

// A header that says more points than there are: up to a hundredth may be missing.
void test_ply_clouds_may_lack_a_few_points(test_state* test)
{
    enum { SAID = 400 };
    for (uint32_t variant = 0; variant < 16; ++variant) {
        bool binary = variant % 2 != 0, within = variant / 2 % 2 != 0, many = variant / 4 % 2 != 0;
        bool faces = variant / 8 != 0; // then it is no cloud
        static char text[16 * SAID];
        uint32_t missing = many ? 5 : 3;
        size_t size = (size_t)snprintf(
            text, sizeof(text),
            "ply\nformat %s 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\n%send_header\n",
            binary ? "binary_little_endian" : "ascii", SAID,
            faces ? "element face 1\nproperty list uchar int vertex_indices\n" : "");
        for (uint32_t i = 0; i < SAID - missing; ++i) {
            const float p[3] = {(float)i, 0.5f, 1.0f};
            if (binary) {
                memcpy(text + size, p, sizeof(p));
                size += sizeof(p);
            } else {
                size += (size_t)snprintf(text + size, sizeof(text) - size, "%u 0.5 1\n", i);
            }
        }
        size_t part = binary ? 5 : 3; // of another point: it is left out
        if (within) {
            memcpy(text + size, "7 8 9", part);
            size += part;
        }
        test_log log = {0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_scene* scene = NULL;
        CHECK_EQUAL(STP_OK, stp_scene_create(context, &scene));
        stp_result result = stp_import_memory(scene, "a.ply", text, size, &(stp_import_desc){0});
        bool opens = !many && !faces;
        CHECK_EQUAL(opens ? STP_OK : STP_ERROR_TRUNCATED, result);
        CHECK_EQUAL(opens ? 0 : 1, log.errors);
        if (opens) {
            CHECK(strstr(log.warning, "a.ply: 3 of 400 points are missing") != NULL);
            CHECK_EQUAL(SAID - 3, scene->point_sets[0].point_count);
        }
        stp_scene_destroy(scene);
        stp_context_destroy(context);
    }
}

// Rows may share a line: none are missing.
void test_ply_rows_may_share_lines(test_state* test)
{
    enum { SAID = 300 };
    static char text[16 * SAID];
    size_t size = (size_t)snprintf(text, sizeof(text),
                                   "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\n"
                                   "property float y\nproperty float z\nend_header\n",
                                   SAID);
    for (uint32_t i = 0; i < SAID; ++i) {
        size += (size_t)snprintf(text + size, sizeof(text) - size, "%u 0.5 1%c", i,
                                 i % 150 == 7 ? ' ' : '\n');
    }
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_result result;
    stp_scene* scene = import_bytes(context, "a.ply", text, size, &result);
    CHECK(scene != NULL);
    CHECK_EQUAL(SAID, scene->point_sets[0].point_count);
    CHECK(strstr(log.warning, "missing") == NULL);
    stp_scene_destroy(scene);
    stp_context_destroy(context);
}

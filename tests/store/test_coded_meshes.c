// SPDX-License-Identifier: MIT
// Files with meshes as clusters: write, read, damage.
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "store/clusters/clusters.h"

#include <string.h>
#include <unistd.h>

static const char* scratch_path(char path[256], const char* name)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp_%s_%ld.stip", folder != NULL ? folder : "/tmp", name,
             (long)getpid());
    return path;
}

/// Writes a sample with coded meshes. @return its bytes, which the caller frees, or NULL
static unsigned char* write_sample(stp_context* context, uint64_t seed, size_t* size)
{
    char path[256];
    scratch_path(path, "coded");
    stp_arena arena = stp_arena_create(context, 1 << 16);
    sample made = sample_make(&arena, seed);
    bool coded = sample_code_meshes(&arena, &made, NULL);
    stp_result result = coded ? stp_store_write(context, &made.content, path) : STP_ERROR_IO;
    stp_arena_destroy(&arena);
    unsigned char* bytes = result == STP_OK ? sample_read_file(path, size) : NULL;
    unlink(path);
    return bytes;
}

void test_coded_meshes_round_trip(test_state* test)
{
    char path[256];
    scratch_path(path, "coded_round");
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    for (uint64_t seed = 0; seed < 60; ++seed) {
        stp_arena_mark mark = stp_arena_get_mark(&arena);
        sample made = sample_make(&arena, seed);
        CHECK(sample_code_meshes(&arena, &made, NULL));
        stp_store* store = NULL;
        CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
        CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
        const char* difference = sample_difference(&made.content, store);
        stp_store_close(store);
        CHECK(difference == NULL);
        CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
        stp_arena_rewind(&arena, mark);
    }
    unlink(path);
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

enum { SEED = 175 };

void test_coded_meshes_are_not_columns(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = write_sample(context, SEED, &size);
    CHECK(bytes != NULL);
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open_memory(context, "coded", bytes, size,
                                              &(stp_store_open_desc){0}, &store));
    uint32_t meshes = stp_store_get_directory(store)->mesh_count;
    CHECK(meshes >= 2);
    for (uint32_t i = 0; i < meshes; ++i) {
        stp_store_mesh mesh;
        stp_clusters clusters;
        bool coded = i % 2 == 0;
        log.errors = 0;
        CHECK_EQUAL(coded, stp_store_is_clustered(store, i));
        CHECK_EQUAL(coded ? STP_ERROR_ARGUMENT : STP_OK, stp_store_get_mesh(store, i, &mesh));
        CHECK_EQUAL(coded ? STP_OK : STP_ERROR_ARGUMENT,
                    stp_store_get_clusters(store, i, &clusters));
        CHECK_EQUAL(1, log.errors);
    }
    stp_clusters clusters;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_get_clusters(store, meshes, &clusters));
    stp_store_close(store);
    free(bytes);
    stp_context_destroy(context);
}

void test_coded_meshes_are_refused_by_readers_that_do_not_know_them(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = write_sample(context, SEED, &size);
    CHECK(bytes != NULL);
    unsigned char* entry = find_section(bytes, STP_SECTION_CLUSTERS);
    CHECK(entry != NULL);
    CHECK_EQUAL(STP_SECTION_CRITICAL, stp_read_u32(entry + 4));
    stp_write_u32(entry, 4000); // as for a reader that does not know type 32
    reseal(bytes, size);
    stp_store* store = NULL;
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, stp_store_open_memory(context, "coded", bytes, size,
                                                             &(stp_store_open_desc){0}, &store));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "needs a reader that knows sections of type 4000") != NULL);
    free(bytes);
    stp_context_destroy(context);
}

static uint64_t use_meshes(stp_store* store)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < stp_store_get_directory(store)->mesh_count; ++i) {
        stp_clusters clusters;
        stp_store_mesh mesh;
        if (!stp_store_is_clustered(store, i)) {
            sum += stp_store_get_mesh(store, i, &mesh) == STP_OK ? 1 : 0;
        } else if (stp_store_get_clusters(store, i, &clusters) == STP_OK) {
            for (uint32_t k = 0; k < clusters.cluster_count; ++k) {
                stp_cluster cluster;
                float positions[3 * STP_CLUSTER_VERTICES];
                stp_clusters_get(&clusters, k, &cluster);
                stp_cluster_positions(&clusters, &cluster, positions);
                sum += cluster.triangle_count + (positions[0] > 0.0f ? 1 : 0);
            }
        }
    }
    return sum;
}

void test_coded_meshes_survive_every_damage(test_state* test)
{
    static volatile uint64_t sink;
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    size_t size = 0;
    unsigned char* bytes = write_sample(context, SEED, &size);
    CHECK(bytes != NULL);
    unsigned char* section = find_section(bytes, STP_SECTION_CLUSTERS);
    CHECK(section != NULL);
    uint64_t records = stp_read_u64(section + 8), record_bytes = stp_read_u64(section + 16);
    void* copy = NULL;
    CHECK_EQUAL(0, posix_memalign(&copy, 64, size));
    unsigned opened = 0, refused = 0;
    for (size_t at = 0; at < size; ++at) { // the cluster records and all blocks
        bool record = at >= records && at < records + record_bytes;
        if (!record && at < stp_read_u64(bytes + 24)) {
            continue;
        }
        memcpy(copy, bytes, size);
        ((unsigned char*)copy)[at] ^= at % 3 == 0 ? 0x81 : 0x02;
        reseal(copy, size);
        stp_store* store = NULL;
        if (stp_store_open_memory(context, "coded", copy, size, &(stp_store_open_desc){0},
                                  &store) == STP_OK) {
            sink = sink + use_meshes(store);
            stp_store_check_report report;
            refused += stp_store_check_open(store, false, &report) == STP_OK ? 0 : 1;
            stp_store_close(store);
            opened += 1;
        }
    }
    CHECK(opened > 100 && refused > 20);
    free(copy);
    free(bytes);
    stp_context_destroy(context);
}

void test_coded_meshes_that_no_reader_takes_are_not_written(test_state* test)
{
    char path[256];
    scratch_path(path, "coded_bad");
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 1 << 16);
    for (int fault = 0; fault < 3; ++fault) {
        sample made = sample_make(&arena, SEED);
        CHECK(sample_code_meshes(&arena, &made, NULL));
        stp_coded_mesh coded = made.content.coded_meshes[0];
        stp_coded_mesh* list =
            stp_arena_alloc_array(&arena, made.content.directory.mesh_count, sizeof(*list));
        CHECK(list != NULL);
        memcpy(list, made.content.coded_meshes, made.content.directory.mesh_count * sizeof(*list));
        list[0].size = fault == 0 ? 3 : fault == 1 ? coded.size - 4 : coded.size;
        list[0].triangle_count += fault == 2 ? 1 : 0;
        made.content.coded_meshes = list;
        log.errors = 0;
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_write(context, &made.content, path));
        CHECK_EQUAL(1, log.errors);
        CHECK(access(path, F_OK) != 0);
    }
    stp_arena_destroy(&arena);
    stp_context_destroy(context);
}

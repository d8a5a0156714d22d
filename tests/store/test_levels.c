// SPDX-License-Identifier: MIT
// Levels in a file (src/store/file/levels.c): write, read, refuse.
#include "support_expected.h"
#include "support_levels.h"
#include "support_reader.h"
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "store/file/block_order.h"
#include "store/file/store_state.h"

#include <float.h>
#include <string.h>

static bool set_up(levels_fixture* f, test_log* log)
{
    stp_context* context = test_context(NULL, 1, log);
    return context != NULL && levels_set_up(f, context) && levels_write(f, &f->content) == STP_OK &&
           f->bytes != NULL;
}

static void tear_down(levels_fixture* f)
{
    levels_tear_down(f);
    stp_context_destroy(f->context);
}

/// A copy that can be damaged. The caller frees it.
static unsigned char* copy_bytes(const levels_fixture* f)
{
    void* copy = NULL;
    if (posix_memalign(&copy, 64, f->size) == 0) {
        memcpy(copy, f->bytes, f->size);
    }
    return copy;
}

static bool is_float(float expected, float found)
{
    return memcmp(&expected, &found, sizeof(found)) == 0;
}

void test_levels_come_back(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    stp_store* store;
    CHECK_EQUAL(STP_OK, levels_open(&f, 0, &store));
    CHECK_EQUAL(3, stp_store_format_minor(store));
    CHECK(sample_difference(&f.content, store) == NULL);
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(LEVELS_LEVELS, d->level_count);
    CHECK_EQUAL(LEVELS_CLUSTERS, d->level_cluster_count);
    CHECK_EQUAL(LEVELS_GROUPS, d->level_group_count);
    CHECK_EQUAL(LEVELS_OWN, stp_store_first_level_mesh(d));
    CHECK(memcmp(d->level_clusters, f.clusters, sizeof(f.clusters)) == 0);
    CHECK(memcmp(d->level_groups, f.groups, sizeof(f.groups)) == 0);
    static const stp_store_level levels[] = {
        {0, 2, 0, 0, 2, 2.0f, FLT_MAX},
        {0, 3, 0, 2, 2, 0.5f, 2.0f},
        {2, 4, STP_LEVEL_FROM_OUTSIDE, 4, 3, 0.0f, 2.0f},
    };
    for (uint32_t i = 0; i < LEVELS_LEVELS; ++i) {
        CHECK_EQUAL(levels[i].node, d->levels[i].node);
        CHECK_EQUAL(levels[i].mesh, d->levels[i].mesh);
        CHECK_EQUAL(levels[i].flags, d->levels[i].flags);
        CHECK_EQUAL(levels[i].first_cluster, d->levels[i].first_cluster);
        CHECK_EQUAL(levels[i].cluster_count, d->levels[i].cluster_count);
        CHECK(is_float(levels[i].least, d->levels[i].least));
        CHECK(is_float(levels[i].most, d->levels[i].most));
    }
    static const uint32_t starts[LEVELS_NODES + 1] = {0, 2, 2, 3};
    CHECK(memcmp(d->level_starts, starts, sizeof(starts)) == 0);
    for (uint32_t type = STP_SECTION_LEVELS; type <= STP_SECTION_LEVEL_FIGURES; ++type) {
        CHECK_EQUAL(0, store->known[type]->flags & STP_SECTION_CRITICAL);
    }
    const stp_store_level_figures* figures = stp_store_get_level_figures(store);
    CHECK(figures != NULL && figures->levels == LEVELS_LEVELS);
    uint64_t triangles = 0, bytes = 0;
    for (uint32_t i = LEVELS_OWN; i < LEVELS_OWN + LEVELS_LEVELS; ++i) {
        triangles += f.coded[i].triangle_count;
        bytes += f.coded[i].size;
    }
    CHECK(figures->triangles == triangles && figures->bytes == bytes);
    stp_store* head;
    const stp_store_open_desc summary = {.summary_only = true};
    CHECK_EQUAL(STP_OK,
                stp_store_open_memory(f.context, "levels", f.bytes, f.size, &summary, &head));
    CHECK(memcmp(stp_store_get_level_figures(head), figures, sizeof(*figures)) == 0);
    stp_store_close(head);
    stp_store_stored_mesh found;
    CHECK_EQUAL(STP_OK, stp_store_find_mesh_by_key(store, f.keys[3], &found));
    CHECK_EQUAL(3, found.index);
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    CHECK_EQUAL(f.size, report.bytes_checked);
    stp_store_close(store);
    tear_down(&f);
}

void test_levels_load_like_meshes(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    stp_store* store;
    CHECK_EQUAL(STP_OK, levels_open(&f, 0, &store));
    stp_residency* residency;
    const stp_residency_desc desc = {.thread_count = 1};
    CHECK_EQUAL(STP_OK, stp_residency_create(store, &desc, &residency));
    const stp_data_request want = {.kind = STP_RESIDENT_MESH, .index = 4, .need = 2.0f};
    (void)residency_settle(residency, &want, 1);
    stp_clusters clusters;
    CHECK_EQUAL(STP_OK, stp_store_get_clusters(store, 4, &clusters));
    CHECK_EQUAL(3, clusters.cluster_count);
    CHECK_EQUAL(f.coded[4].size, clusters.size);
    stp_residency_destroy(residency);
    stp_store_close(store);
    tear_down(&f);
}

void test_levels_may_be_missing_from_partial_files(test_state* test)
{
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    stp_store* store;
    CHECK_EQUAL(STP_OK, levels_open(&f, stp_read_u64(f.bytes + 24), &store));
    CHECK_EQUAL(LEVELS_LEVELS, stp_store_get_directory(store)->level_count);
    stp_clusters clusters;
    CHECK_EQUAL(STP_ERROR_TRUNCATED, stp_store_get_clusters(store, 4, &clusters));
    stp_store_close(store);
    tear_down(&f);
}

void test_levels_can_be_ignored(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    unsigned char* copy = copy_bytes(&f);
    CHECK(copy != NULL);
    for (uint32_t type = STP_SECTION_LEVELS; type <= STP_SECTION_LEVEL_FIGURES; ++type) {
        stp_write_u32(find_section(copy, type), 4000 + type); // as for a reader of version 1.2
    }
    reseal(copy, f.size);
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open_memory(f.context, "levels", copy, f.size,
                                              &(stp_store_open_desc){0}, &store));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(0, d->level_count);
    CHECK(d->level_starts == NULL && d->levels == NULL);
    stp_clusters clusters;
    CHECK_EQUAL(STP_OK, stp_store_get_clusters(store, 4, &clusters));
    stp_store_close(store);
    free(copy);
    tear_down(&f);
}

void test_levels_change_nothing_where_there_are_none(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    stp_store_content without = levels_without(&f);
    CHECK_EQUAL(STP_OK, levels_write(&f, &without));
    for (uint32_t type = STP_SECTION_LEVELS; type <= STP_SECTION_LEVEL_FIGURES; ++type) {
        CHECK(find_section(f.bytes, type) == NULL);
    }
    stp_store* store;
    CHECK_EQUAL(STP_OK, levels_open(&f, 0, &store));
    CHECK_EQUAL(2, stp_store_format_minor(store));
    CHECK(stp_store_get_directory(store)->level_starts == NULL);
    stp_store_close(store);
    tear_down(&f);
}

void test_levels_are_not_counted(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    stp_store_content without = levels_without(&f);
    stp_store_summary with = {0}, plain = {0};
    CHECK_EQUAL(STP_OK, stp_store_summarise_content(f.context, &f.content, &with));
    CHECK_EQUAL(STP_OK, stp_store_summarise_content(f.context, &without, &plain));
    CHECK(memcmp(&with.figures, &plain.figures, sizeof(plain.figures)) == 0);
    CHECK_EQUAL(212, with.figures.unique_triangles);
    CHECK_EQUAL(LEVELS_OWN, with.mesh_count);
    CHECK_EQUAL(2, with.material_count); // one of parts, one of nothing
    CHECK_EQUAL(2, plain.material_count);
    stp_store_summary_destroy(f.context, &with);
    stp_store_summary_destroy(f.context, &plain);
    f.meshes[1].material = 2; // shared by a part and a level
    CHECK_EQUAL(STP_OK, stp_store_summarise_content(f.context, &f.content, &with));
    CHECK_EQUAL(3, with.material_count);
    stp_store_summary_destroy(f.context, &with);
    tear_down(&f);
}

void test_levels_that_are_coarse_come_first(test_state* test)
{
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    stp_store_plan plan;
    CHECK_EQUAL(STP_OK, stp_store_plan_make(f.context, &f.content, 4096, &plan));
    CHECK(plan.mesh_blocks[2] < plan.mesh_blocks[3]); // by the size, as all show the same area
    CHECK(plan.mesh_blocks[3] < plan.mesh_blocks[4]);
    stp_store_plan_destroy(f.context, &plan);
    f.edges[0].transform.m[0][0] = 1e6; // node 0 shows more than the root
    f.edges[0].transform.m[2][2] = 1e6;
    f.levels[0].node = 1;
    f.levels[1].node = 1;
    CHECK_EQUAL(STP_OK, stp_store_plan_make(f.context, &f.content, 4096, &plan));
    CHECK(plan.mesh_blocks[0] < plan.mesh_blocks[2]);
    stp_store_plan_destroy(f.context, &plan);
    f.levels[0].node = 0;
    f.levels[1].node = 0;
    CHECK_EQUAL(STP_OK, stp_store_plan_make(f.context, &f.content, 4096, &plan));
    CHECK(plan.mesh_blocks[3] < plan.mesh_blocks[4] && plan.mesh_blocks[3] < plan.mesh_blocks[1]);
    stp_store_plan_destroy(f.context, &plan);
    tear_down(&f);
}

/// A value in a record of a section that makes the file invalid.
typedef struct fault {
    uint32_t type, at, value;
    const char* message;
} fault;

void test_levels_that_are_invalid_are_refused(test_state* test)
{
    static const fault faults[] = {
        {STP_SECTION_LEVELS, 16, 3, "level 2: node 3 does not exist (there are 3)"},
        {STP_SECTION_LEVELS, 20, 2, "level 2: flags 0x2 are not defined in this version"},
        {STP_SECTION_LEVELS, 0, 1, "level 1: node 0 comes after node 1"},
        {STP_SECTION_LEVEL_CLUSTERS, 0, 2, "level cluster 0: group 2 does not exist"},
        {STP_SECTION_LEVEL_CLUSTERS, 28, 9, "level cluster 2: group 9 does not exist"},
        {STP_SECTION_LEVEL_CLUSTERS, 24, 1,
         "level cluster 2: the error does not grow from group 1, which made it, to group 1"},
        {STP_SECTION_LEVEL_CLUSTERS, 8, 129,
         "level cluster 0: 129 one-sided triangles are more than 128"},
        {STP_SECTION_LEVEL_GROUPS, 12, 0x80800000, "level group 0: a radius of -1.17549e-38"},
        {STP_SECTION_LEVEL_GROUPS, 36, 0, "level group 1: a radius of 3 or an error of 0"},
        {STP_SECTION_LEVEL_GROUPS, 16, 0x7F800000, "level group 0 has a number that is not finite"},
        {STP_SECTION_LEVEL_GROUPS, 0, 0x7FC00000, "level group 0 has a number that is not finite"},
        {STP_SECTION_LEVEL_FIGURES, 0, 4, "1 records of figures of levels for 3 levels"},
        {STP_SECTION_LEVEL_FIGURES, 8, 1, "figures of levels: 1 triangles in "},
        {STP_SECTION_LEVEL_FIGURES, 16, 1, " triangles in 1 bytes, but levels have "},
        {STP_SECTION_PARTS, 4, 2, "part 0: mesh 2 is a level, which belongs to no node"},
    };
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    for (size_t i = 0; i < sizeof(faults) / sizeof(faults[0]); ++i) {
        unsigned char* copy = copy_bytes(&f);
        CHECK(copy != NULL);
        stp_store_section section = reseal_section(find_section(copy, faults[i].type));
        CHECK((section.flags & STP_SECTION_PACKED) == 0 && faults[i].at + 4 <= section.size);
        stp_write_u32(copy + section.offset + faults[i].at, faults[i].value);
        reseal(copy, f.size);
        stp_store* store = NULL;
        stp_result result = stp_store_open_memory(f.context, "levels", copy, f.size,
                                                  &(stp_store_open_desc){0}, &store);
        CHECK_EQUAL(STP_ERROR_FORMAT, result);
        CHECK(strstr(log.text, faults[i].message) != NULL);
        free(copy);
    }
    tear_down(&f);
}

/// Opens the file as if it had no section of this type.
static stp_result open_without(levels_fixture* f, uint32_t type)
{
    unsigned char* copy = copy_bytes(f);
    stp_store* store = NULL;
    stp_write_u32(find_section(copy, type), 4000);
    reseal(copy, f->size);
    stp_result result = stp_store_open_memory(f->context, "levels", copy, f->size,
                                              &(stp_store_open_desc){0}, &store);
    stp_store_close(store);
    free(copy);
    return result;
}

void test_levels_need_all_their_sections(test_state* test)
{
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    CHECK_EQUAL(STP_ERROR_FORMAT, open_without(&f, STP_SECTION_LEVELS));
    CHECK(strstr(log.text, "has 7 level clusters, but its levels have 0") != NULL);
    CHECK_EQUAL(STP_ERROR_FORMAT, open_without(&f, STP_SECTION_LEVEL_CLUSTERS));
    CHECK(strstr(log.text, "has 0 level clusters, but its levels have 7") != NULL);
    CHECK_EQUAL(STP_ERROR_FORMAT, open_without(&f, STP_SECTION_LEVEL_GROUPS));
    CHECK(strstr(log.text, "level cluster 0: group 1 does not exist (there are 0)") != NULL);
    tear_down(&f);
}

void test_levels_have_no_more_one_sided_triangles_than_triangles(test_state* test)
{
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    stp_store_section section = reseal_section(find_section(f.bytes, STP_SECTION_LEVEL_CLUSTERS));
    stp_write_u32(f.bytes + section.offset + 12 + 8, 29); // of 28 triangles
    reseal(f.bytes, f.size);
    stp_store* store;
    stp_clusters clusters;
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, levels_open(&f, 0, &store)); // blocks are not looked at
    CHECK_EQUAL(STP_OK, stp_store_get_clusters(store, 3, &clusters));
    CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_get_clusters(store, 2, &clusters));
    CHECK(strstr(log.text, "mesh 2 has a cluster with more one-sided triangles") != NULL);
    CHECK_EQUAL(STP_ERROR_FORMAT, stp_store_check_open(store, false, &report));
    stp_store_close(store);
    tear_down(&f);
}

/// Writes the content, which must be refused. @return whether the message is as expected
static bool is_refused(levels_fixture* f, test_log* log, const char* message)
{
    log->text[0] = '\0';
    return levels_write(f, &f->content) == STP_ERROR_ARGUMENT && strstr(log->text, message) != NULL;
}

void test_levels_that_no_reader_takes_are_not_written(test_state* test)
{
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    stp_store_directory* d = &f.content.directory;
    f.levels[2].node = 3;
    CHECK(is_refused(&f, &log, "level 2: node 3 does not exist"));
    f.levels[2].node = 2;
    f.levels[0].node = 1;
    CHECK(is_refused(&f, &log, "level 1: node 0 comes after node 1"));
    f.levels[0].node = 0;
    f.clusters[1].one_sided = 29;
    CHECK(is_refused(&f, &log, "mesh 2 has a cluster with more one-sided triangles"));
    f.clusters[1].one_sided = 28;
    f.groups[1].error = 0.25f;
    CHECK(is_refused(&f, &log, "level cluster 2: the error does not grow"));
    f.groups[1].error = 2.0f;
    f.parts[1].index = 4;
    CHECK(is_refused(&f, &log, "part 1: mesh 4 is a level"));
    f.parts[1].index = 1;
    d->level_cluster_count -= 1;
    CHECK(is_refused(&f, &log, "has 6 level clusters, but its levels have 7"));
    d->level_cluster_count += 1;
    d->level_count = LEVELS_MESHES + 1;
    CHECK(is_refused(&f, &log, "has 6 levels, but only 5 meshes"));
    d->level_count = LEVELS_LEVELS;
    stp_coded_mesh coded = f.coded[3];
    f.coded[3] = (stp_coded_mesh){0};
    CHECK(is_refused(&f, &log, "level 1: mesh 3 is not stored as clusters"));
    f.coded[3] = coded;
    CHECK_EQUAL(STP_OK, levels_write(&f, &f.content));
    tear_down(&f);
}

void test_levels_survive_every_damage(test_state* test)
{
    levels_fixture f;
    test_log log = {.errors = 0};
    CHECK(set_up(&f, &log));
    unsigned char* copy = copy_bytes(&f);
    CHECK(copy != NULL);
    unsigned opened = 0, refused = 0;
    for (uint32_t type = STP_SECTION_LEVELS; type <= STP_SECTION_LEVEL_FIGURES; ++type) {
        stp_store_section section = reseal_section(find_section(f.bytes, type));
        for (uint64_t at = section.offset; at < section.offset + section.size; ++at) {
            memcpy(copy, f.bytes, f.size);
            copy[at] ^= at % 3 == 0 ? 0x81 : 0x02;
            reseal(copy, f.size);
            stp_store* store = NULL;
            bool open = stp_store_open_memory(f.context, "levels", copy, f.size,
                                              &(stp_store_open_desc){0}, &store) == STP_OK;
            for (uint32_t i = 0; open && i < LEVELS_LEVELS; ++i) {
                stp_clusters clusters;
                (void)!stp_store_get_clusters(store, LEVELS_OWN + i, &clusters);
            }
            stp_store_close(store);
            opened += open;
            refused += !open;
        }
    }
    CHECK(opened > 20 && refused > 50);
    free(copy);
    tear_down(&f);
}

// A version 1.3 file with levels must open forever. STP_WRITE_GOLDEN writes it and its content.
void test_levels_of_version_1_3_are_still_read(test_state* test)
{
    static const char golden[] = STP_TEST_SOURCE_DIR "/tests/golden/store/v1/levels-1.3";
    char path[512];
    levels_fixture f;
    CHECK(set_up(&f, NULL));
    snprintf(path, sizeof(path), "%s.stip", golden);
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        CHECK_EQUAL(STP_OK, stp_store_write(f.context, &f.content, path));
    }
    stp_store* store = NULL;
    CHECK_EQUAL(STP_OK, stp_store_open(f.context, path, &store));
    CHECK_EQUAL(3, stp_store_format_minor(store));
    stp_store_check_report report;
    CHECK_EQUAL(STP_OK, stp_store_check_open(store, false, &report));
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(LEVELS_LEVELS, d->level_count);
    CHECK(memcmp(d->level_clusters, f.clusters, sizeof(f.clusters)) == 0);
    CHECK(memcmp(d->level_groups, f.groups, sizeof(f.groups)) == 0);
    if (getenv("STP_WRITE_GOLDEN") != NULL) {
        json_t* expected = sample_expected_json(&f.content, stp_store_get_summary(store));
        snprintf(path, sizeof(path), "%s.json", golden);
        CHECK(expected != NULL);
        CHECK_EQUAL(0, json_dump_file(expected, path, JSON_INDENT(1) | JSON_REAL_PRECISION(17)));
        json_decref(expected);
    }
    stp_store_close(store);
    tear_down(&f);
}

// SPDX-License-Identifier: MIT
#include "work_helpers.h"

#include "base/io/bytes.h"
#include "builder/stored_results.h"

enum { SPLATS = 37, ENTRIES = 5 + 17 + 37, MESH_BYTES = 333 };

typedef struct sample {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint8_t materials[SPLATS], colors[3 * ENTRIES], coverages[ENTRIES];
    stp_splats splats;
} sample;

static void fill(void* bytes, size_t size, uint64_t seed)
{
    for (size_t i = 0; i < size; ++i) {
        ((unsigned char*)bytes)[i] = (unsigned char)stp_rng_hash(seed, i);
    }
}

static void make_sample(sample* s)
{
    fill(s, sizeof(*s), 3);
    for (int i = 0; i < SPLATS; ++i) {
        s->materials[i] = (uint8_t)(i % 5);
    }
    s->splats = (stp_splats){
        .count = SPLATS,
        .origin = {-1.5f, 2.25f, 1e6f},
        .step = 0.125f,
        .positions = s->positions,
        .normals = s->normals,
        .materials = s->materials,
        .octave_count = 3,
        .octave_ends = {5, 17, SPLATS},
        .colors = s->colors,
        .coverages = s->coverages,
        .table = {.size = 3, .count = {1, 9, SPLATS}, .radius = {8.0f, 2.5f, 0.75f}},
        .candidate_radius = 0.03125f,
        .paper_radius = 0.5f,
        .paper_count = 11,
    };
}

static bool same_bytes(const void* a, const void* b, size_t size)
{
    return (uintptr_t)a % 64 == 0 && memcmp(a, b, size) == 0;
}

static bool is_sample(const stp_splats* s, const sample* expected)
{
    const stp_splats* e = &expected->splats;
    return s->count == e->count && memcmp(&s->origin, &e->origin, sizeof(e->origin)) == 0 &&
           s->step == e->step && s->octave_count == e->octave_count &&
           memcmp(s->octave_ends, e->octave_ends, sizeof(e->octave_ends)) == 0 &&
           memcmp(&s->table, &e->table, sizeof(e->table)) == 0 &&
           s->candidate_radius == e->candidate_radius && s->paper_radius == e->paper_radius &&
           s->paper_count == e->paper_count &&
           same_bytes(s->positions, expected->positions, sizeof(expected->positions)) &&
           same_bytes(s->normals, expected->normals, sizeof(expected->normals)) &&
           same_bytes(s->materials, expected->materials, sizeof(expected->materials)) &&
           same_bytes(s->colors, expected->colors, sizeof(expected->colors)) &&
           same_bytes(s->coverages, expected->coverages, sizeof(expected->coverages));
}

void test_results_are_found_as_they_were_stored(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    static sample s;
    make_sample(&s);
    unsigned char mesh_bytes[MESH_BYTES];
    fill(mesh_bytes, MESH_BYTES, 4);
    stp_coded_mesh mesh = {.bytes = mesh_bytes,
                           .size = MESH_BYTES,
                           .cluster_count = 2,
                           .triangle_count = 200,
                           .vertex_count = 150,
                           .bounds = {{-1, -2, -3}, {4, 5, 6}}};
    stp_splats nothing = {.candidate_radius = 1.0f};
    for (int round = 0; round < 2; ++round) {
        stp_work* work = open_work(context, &place);
        CHECK(work != NULL);
        stp_splats found;
        stp_coded_mesh coded;
        uint32_t candidates = 0;
        CHECK_EQUAL(round, stp_work_find_splat_set(work, work_key(1), 5, &found, &candidates));
        CHECK_EQUAL(STP_OK, stp_work_store_splat_set(work, work_key(1), &s.splats, 1234, &found));
        CHECK(is_sample(&found, &s));
        CHECK(stp_work_find_splat_set(work, work_key(1), 5, &found, &candidates));
        CHECK(is_sample(&found, &s));
        CHECK_EQUAL(1234, candidates);
        // a set without visible splats is a result too
        CHECK_EQUAL(STP_OK, stp_work_store_splat_set(work, work_key(2), &nothing, 0, NULL));
        CHECK(stp_work_find_splat_set(work, work_key(2), 1, &found, &candidates));
        CHECK_EQUAL(0, found.count);
        CHECK_EQUAL(0, candidates);
        CHECK_EQUAL(STP_OK, stp_work_store_mesh(work, work_key(3), &mesh, &coded));
        for (int look = 0; look < 2; ++look) {
            CHECK_EQUAL(MESH_BYTES, coded.size);
            CHECK(same_bytes(coded.bytes, mesh_bytes, MESH_BYTES));
            CHECK_EQUAL(2, coded.cluster_count);
            CHECK_EQUAL(200, coded.triangle_count);
            CHECK_EQUAL(150, coded.vertex_count);
            CHECK(memcmp(&coded.bounds, &mesh.bounds, sizeof(mesh.bounds)) == 0);
            coded = (stp_coded_mesh){0};
            CHECK(stp_work_find_mesh(work, work_key(3), &coded));
        }
        stp_work_close(work, round == 1);
    }
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

void test_results_that_make_no_sense_are_made_anew(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL && make_work_place(&place));
    static sample s;
    make_sample(&s);
    stp_work* work = open_work(context, &place);
    CHECK(work != NULL);
    CHECK_EQUAL(STP_OK, stp_work_store_splat_set(work, work_key(0), &s.splats, 1, NULL));
    size_t size = 0;
    const unsigned char* whole = stp_work_find(work, work_key(0), &size);
    CHECK(whole != NULL && size < 2048);
    stp_splats found;
    uint32_t unused;
    CHECK(!stp_work_find_splat_set(work, work_key(0), 4, &found, &unused)); // shading 4 is used
    // any header with a valid checksum: a result that is found can be read to its end
    uint64_t sum = 0, refused = 0;
    for (uint32_t round = 1; round < 1500; ++round) {
        unsigned char bytes[2048];
        memcpy(bytes, whole, size);
        uint32_t at = stp_rng_below(9, round, 704 / 4) * 4;
        uint32_t value = round % 3 == 0 ? (uint32_t)stp_rng_hash(8, round) : round % 64;
        stp_write_u32(bytes + (round % 2 == 0 ? at % 64 : at), value);
        const stp_bytes part = {bytes, round % 7 == 0 ? round % size : size};
        stp_hash key = work_key(round);
        CHECK_EQUAL(STP_OK, stp_work_store(work, key, &part, 1, NULL));
        stp_coded_mesh mesh;
        if (stp_work_find_splat_set(work, key, 256, &found, &unused)) {
            CHECK(found.count == 0 || found.octave_ends[found.octave_count - 1] == found.count);
            sum += stp_checksum(&(stp_bytes){found.positions, 6 * (size_t)found.count}, 1);
        } else {
            refused += 1;
            CHECK_EQUAL(STP_OK, stp_work_store_splat_set(work, key, &s.splats, 7, &found));
            CHECK(is_sample(&found, &s)); // not the invalid one stored before
        }
        CHECK(!stp_work_find_mesh(work, key, &mesh) || value == 2);
    }
    CHECK(sum != 0 && refused > 200);
    s.splats.octave_ends[1] = 3;
    CHECK_EQUAL(STP_ERROR_FORMAT, stp_work_store_splat_set(work, work_key(1), &s.splats, 1, NULL));
    stp_work_close(work, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

static void store_sample(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    static sample s;
    stp_work* work = user;
    for (size_t i = begin; i < end; ++i) {
        stp_splats found;
        (void)!stp_work_store_splat_set(work, work_key((uint32_t)i / 2), &s.splats, 0, &found);
    }
}

void test_results_are_stored_by_jobs(test_state* test)
{
    work_place place;
    stp_context* context = test_context(NULL, 3, NULL);
    CHECK(context != NULL && make_work_place(&place));
    stp_work* work = open_work(context, &place);
    CHECK(work != NULL);
    stp_parallel_for(context, 100, 1, store_sample, work);
    stp_work_report report;
    stp_work_get_report(work, &report);
    CHECK_EQUAL(50, report.stored);
    stp_work_close(work, true);
    CHECK(remove_work_place(&place));
    stp_context_destroy(context);
}

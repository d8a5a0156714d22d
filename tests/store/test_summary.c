// SPDX-License-Identifier: MIT
// Summaries, scene parts and keys: against the written content and brute force.
#include "support_reseal.h"
#include "support_sample.h"
#include "tests.h"

#include "base/io/file.h"

#include <string.h>
#include <unistd.h>

static void temporary_path(char path[256], const char* name)
{
    const char* folder = getenv("TMPDIR");
    snprintf(path, 256, "%s/stp_%s_%ld.stip", folder != NULL ? folder : "/tmp", name,
             (long)getpid());
}

static bool same_text(const char* a, const char* b)
{
    return (a == NULL) == (b == NULL) && (a == NULL || strcmp(a, b) == 0);
}

static bool same_summary(const stp_store_summary* a, const stp_store_summary* b)
{
    bool same = memcmp(&a->figures, &b->figures, sizeof(a->figures)) == 0 &&
                memcmp(&a->bounds, &b->bounds, sizeof(a->bounds)) == 0 &&
                a->material_count == b->material_count && a->texture_count == b->texture_count &&
                a->mesh_count == b->mesh_count && a->point_set_count == b->point_set_count &&
                a->part_count == b->part_count;
    for (uint32_t i = 0; same && i < a->part_count; ++i) {
        same = same_text(a->parts[i].name, b->parts[i].name) &&
               a->parts[i].object == b->parts[i].object &&
               memcmp(&a->parts[i].figures, &b->parts[i].figures, sizeof(a->figures)) == 0;
    }
    return same;
}

// Content does not give the compressed size of its splats: it is at most the planned one, and the
// file's own check compares it with the blocks. @return false if it is larger
static bool take_splat_bytes(stp_store_summary* planned, const stp_store_summary* stored)
{
    bool good = stored != NULL && stored->part_count == planned->part_count &&
                stored->figures.splat_bytes <= planned->figures.splat_bytes &&
                (stored->figures.splat_bytes != 0) == (planned->figures.splat_bytes != 0);
    planned->figures.splat_bytes = good ? stored->figures.splat_bytes : 0;
    for (uint32_t i = 0; good && i < planned->part_count; ++i) {
        planned->parts[i].figures.splat_bytes = stored->parts[i].figures.splat_bytes;
    }
    return good;
}

void test_store_summary_is_read_alone_or_with_all(test_state* test)
{
    char path[256];
    temporary_path(path, "summary");
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    int with_parts = 0;
    for (uint64_t seed = 0; seed < 60; ++seed) {
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        stp_store_summary wanted;
        stp_store *all = NULL, *head = NULL;
        CHECK_EQUAL(STP_OK, stp_store_summarise_content(context, &made.content, &wanted));
        CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
        CHECK_EQUAL(STP_OK, stp_store_open(context, path, &all));
        stp_store_open_desc desc = {.summary_only = true};
        CHECK_EQUAL(STP_OK, stp_store_open_with(context, path, &desc, &head));
        CHECK(take_splat_bytes(&wanted, stp_store_get_summary(all)));
        CHECK(same_summary(&wanted, stp_store_get_summary(all)));
        CHECK(same_summary(&wanted, stp_store_get_summary(head)));
        with_parts += wanted.part_count > 1;

        const stp_store_directory *a = stp_store_get_directory(all),
                                  *b = stp_store_get_directory(head);
        CHECK(b->view_count == a->view_count && b->source_count == a->source_count);
        CHECK(same_text(a->build_json, b->build_json) && a->up == b->up);
        for (uint32_t i = 0; i < a->view_count; ++i) {
            CHECK(same_text(a->views[i].name, b->views[i].name));
        }
        for (uint32_t i = 0; i < a->source_count; ++i) {
            CHECK(same_text(a->sources[i].path, b->sources[i].path));
            CHECK(same_text(a->sources[i].format, b->sources[i].format));
        }
        // nothing else is available
        stp_splats set;
        CHECK(b->root == STP_STORE_NONE && b->node_count == 0 && b->object_count == 0);
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_load_objects(head));
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_store_get_splat_set(head, 0, &set));
        stp_store_close(head);
        stp_store_close(all);
        CHECK_EQUAL(STP_OK, stp_store_check(context, path, false));
        CHECK_EQUAL(STP_OK, stp_store_check(context, path, true));
        stp_store_summary_destroy(context, &wanted);
        stp_arena_destroy(&arena);
    }
    unlink(path);
    CHECK(with_parts > 5);
    stp_context_destroy(context);
}

// The same by recursion over every path.
static void walk_paths(const stp_store_content* content, uint32_t index, stp_store_figures* figures)
{
    const stp_store_directory* d = &content->directory;
    const stp_store_node* node = &d->nodes[index];
    figures->nodes += 1;
    figures->objects += node->part_count != 0;
    figures->instances += node->part_count;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = d->parts[node->first_part + i];
        if (part.kind == STP_STORE_PART_MESH) {
            figures->triangles += content->meshes[part.index].triangle_count;
        } else {
            figures->points += content->point_sets[part.index].point_count;
        }
    }
    if (node->set != STP_STORE_NONE && content->sets[node->set].count != 0) {
        figures->lods += 1;
        figures->surfels += content->sets[node->set].count;
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        walk_paths(content, d->edges[node->first_edge + i].node, figures);
    }
}

void test_store_summary_sums_all_instances(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (uint64_t seed = 0; seed < 200; ++seed) {
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        made.content.census = NULL;
        stp_store_summary found;
        CHECK_EQUAL(STP_OK, stp_store_summarise_content(context, &made.content, &found));
        stp_store_figures wanted = {0};
        const stp_store_directory* d = &made.content.directory;
        if (d->root != STP_STORE_NONE) {
            walk_paths(&made.content, d->root, &wanted);
        }
        const stp_store_figures* f = &found.figures;
        CHECK_EQUAL(wanted.nodes, f->nodes);
        CHECK(f->unique_nodes <= f->nodes);
        CHECK_EQUAL(wanted.objects, f->objects);
        CHECK_EQUAL(wanted.instances, f->instances);
        CHECK_EQUAL(wanted.triangles, f->triangles);
        CHECK_EQUAL(wanted.points, f->points);
        CHECK_EQUAL(wanted.lods, f->lods);
        CHECK_EQUAL(wanted.surfels, f->surfels);
        for (uint32_t i = 0; i < found.part_count; ++i) {
            stp_store_figures part = {0};
            walk_paths(&made.content, d->objects[found.parts[i].object].node, &part);
            CHECK_EQUAL(part.nodes, found.parts[i].figures.nodes);
            CHECK_EQUAL(part.surfels, found.parts[i].figures.surfels);
            CHECK(found.parts[i].figures.unique_nodes <= part.nodes);
        }
        stp_store_summary_destroy(context, &found);
        stp_arena_destroy(&arena);
    }
    stp_context_destroy(context);
}

// Whether a file check passes with a summary of this many unique nodes.
static bool passes_with(stp_context* context, const char* path, uint64_t unique_nodes)
{
    stp_mapped_file file;
    if (stp_file_map(context, path, &file) != STP_OK) {
        return false;
    }
    size_t size = file.size;
    unsigned char* bytes = stp_alloc(context, size);
    memcpy(bytes, file.bytes, size);
    stp_file_unmap(&file);
    for (size_t at = STP_STORE_HEADER_BYTES; at < 4096; at += STP_STORE_SECTION_BYTES) {
        if (stp_read_u32(bytes + at) == STP_SECTION_SUMMARY) {
            stp_write_u64(bytes + stp_read_u64(bytes + at + 8) + 32, unique_nodes);
            break;
        }
    }
    reseal(bytes, size);
    FILE* out = fopen(path, "wb");
    bool passes = out != NULL && fwrite(bytes, 1, size, out) == size && fclose(out) == 0 &&
                  stp_store_check(context, path, false) == STP_OK;
    stp_free(context, bytes);
    return passes;
}

// Nodes that the root does not reach are not counted. Files that count them are valid, too.
void test_store_summary_counts_nodes_that_the_root_reaches(test_state* test)
{
    char path[256];
    temporary_path(path, "reached");
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    int with_others = 0;
    for (uint64_t seed = 0; seed < 60; ++seed) {
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        stp_store_summary found;
        CHECK_EQUAL(STP_OK, stp_store_summarise_content(context, &made.content, &found));
        uint64_t all = made.content.directory.node_count, unique = found.figures.unique_nodes;
        stp_store_summary_destroy(context, &found);
        if (all > unique + 1) {
            CHECK_EQUAL(STP_OK, stp_store_write(context, &made.content, path));
            CHECK(passes_with(context, path, unique));
            CHECK(passes_with(context, path, all));
            CHECK(!passes_with(context, path, all - 1));
            CHECK(!passes_with(context, path, all + 1));
            with_others += 1;
        }
        stp_arena_destroy(&arena);
    }
    unlink(path);
    CHECK(with_others > 3);
    stp_context_destroy(context);
}

// Sixty nodes, each containing the previous one twice: 2^60 uses of one mesh of 100 triangles.
void test_store_summary_stops_at_the_largest_number(test_state* test)
{
    enum { NODES = 61 };
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_node nodes[NODES] = {{.part_count = 1, .set = STP_STORE_NONE}};
    stp_store_edge edges[2 * NODES];
    memset(edges, 0, sizeof(edges));
    for (uint32_t i = 1; i < NODES; ++i) {
        nodes[i] = (stp_store_node){
            .first_edge = 2 * i, .edge_count = 2, .set = STP_STORE_NONE, .first_part = 1};
        edges[2 * i].node = edges[2 * i + 1].node = i - 1;
    }
    stp_store_part part = {STP_STORE_PART_MESH, 0};
    stp_store_mesh mesh = {.triangle_count = 100};
    stp_store_material material = {.base_color_texture.texture = STP_STORE_NONE,
                                   .metallic_roughness_texture.texture = STP_STORE_NONE,
                                   .emissive_texture.texture = STP_STORE_NONE};
    stp_store_content content = {.directory = {.root = NODES - 1,
                                               .node_count = NODES,
                                               .nodes = nodes,
                                               .edge_count = 2 * NODES,
                                               .edges = edges,
                                               .part_count = 1,
                                               .parts = &part,
                                               .mesh_count = 1,
                                               .material_count = 1,
                                               .materials = &material,
                                               .up = 'y'},
                                 .meshes = &mesh};
    stp_store_summary found;
    CHECK_EQUAL(STP_OK, stp_store_summarise_content(context, &content, &found));
    CHECK_EQUAL(UINT64_C(1) << 60, found.figures.instances);
    CHECK_EQUAL(UINT64_MAX, found.figures.triangles);
    CHECK_EQUAL(100, found.figures.unique_triangles);
    CHECK_EQUAL(NODES, found.figures.unique_nodes);
    stp_store_summary_destroy(context, &found);
    stp_context_destroy(context);
}

void test_store_census_sums_small_parts(test_state* test)
{
    enum { COUNT = 200 };
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_store_census_candidate candidates[COUNT];
    for (uint32_t i = 0; i < COUNT; ++i) {
        candidates[i] = (stp_store_census_candidate){1000 + i, i * 7 % COUNT, "part"};
    }
    for (uint32_t count = 0; count <= COUNT; count += count < 60 ? 30 : 1) {
        stp_store_census census;
        CHECK_EQUAL(STP_OK, stp_store_census_create(context, candidates, count, &census));
        CHECK_EQUAL(count > 64 ? 65 : count, census.part_count);
        bool seen[COUNT] = {false};
        uint64_t minimum = UINT64_MAX;
        uint32_t members = 0;
        for (uint32_t i = 0; i < census.part_count; ++i) {
            const stp_store_census_part* part = &census.parts[i];
            CHECK(strcmp(part->name, i == 64 ? "others" : "part") == 0);
            for (uint32_t k = 0; k < part->member_count; ++k, ++members) {
                uint32_t which = part->members[k] - 1000;
                CHECK(which < count && !seen[which]);
                seen[which] = true;
                uint64_t triangles = candidates[which].triangles;
                CHECK(i == 64 ? triangles <= minimum : part->member_count == 1);
                minimum = i < 64 && triangles < minimum ? triangles : minimum;
            }
            CHECK(i == 0 || i == 64 || part->members[0] > census.parts[i - 1].members[0]);
        }
        CHECK_EQUAL(count, members);
        stp_store_census_destroy(context, &census);
    }
    stp_context_destroy(context);
}

// The first set or mesh with a key.
static uint32_t find_key(const stp_hash* keys, uint32_t count, stp_hash key)
{
    for (uint32_t i = 0; keys != NULL && i < count; ++i) {
        if (stp_hash_equal(keys[i], key) && (key.low != 0 || key.high != 0)) {
            return i;
        }
    }
    return STP_STORE_NONE;
}

void test_store_finds_what_was_made_under_a_key(test_state* test)
{
    char path[256];
    temporary_path(path, "keys");
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    int found_sets = 0, found_meshes = 0;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        stp_arena arena = stp_arena_create(context, 1 << 16);
        sample made = sample_make(&arena, seed);
        const stp_store_content* content = &made.content;
        uint32_t sets = content->directory.set_count, meshes = content->directory.mesh_count;
        stp_store* store = NULL;
        CHECK_EQUAL(STP_OK, stp_store_write(context, content, path));
        CHECK_EQUAL(STP_OK, stp_store_open(context, path, &store));
        for (uint32_t i = 0; i <= sets + meshes; ++i) {
            stp_hash key = {.low = 77, .high = seed};
            if (i < sets && content->set_keys != NULL) {
                key = content->set_keys[i];
            } else if (i >= sets && i < sets + meshes && content->mesh_keys != NULL) {
                key = content->mesh_keys[i - sets];
            }
            stp_store_stored_splat_set stored;
            CHECK_EQUAL(STP_OK, stp_store_find_splat_set_by_key(store, key, &stored));
            CHECK_EQUAL(find_key(content->set_keys, sets, key), stored.index);
            if (stored.index != STP_STORE_NONE && stored.splats->count != 0) {
                const stp_splats* wanted = &content->sets[stored.index];
                CHECK_EQUAL(wanted->count, stored.splats->count);
                stp_splats columns;
                CHECK_EQUAL(STP_OK, stp_store_get_splat_set(store, stored.index, &columns));
                CHECK(memcmp(wanted->positions, columns.positions, 6 * (size_t)wanted->count) == 0);
                found_sets += 1;
            }
            stp_store_stored_mesh mesh;
            CHECK_EQUAL(STP_OK, stp_store_find_mesh_by_key(store, key, &mesh));
            CHECK_EQUAL(find_key(content->mesh_keys, meshes, key), mesh.index);
            if (mesh.index != STP_STORE_NONE && mesh.mesh->vertex_count != 0) {
                const stp_store_mesh* wanted = &content->meshes[mesh.index];
                CHECK(memcmp(wanted->positions, mesh.block, 12 * (size_t)wanted->vertex_count) ==
                      0);
                CHECK((mesh.present & 1) == (wanted->normals != NULL));
                found_meshes += 1;
            }
        }
        stp_store_close(store);
        stp_arena_destroy(&arena);
    }
    unlink(path);
    CHECK(found_sets > 10 && found_meshes > 10);
    stp_context_destroy(context);
}

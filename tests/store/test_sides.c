// SPDX-License-Identifier: MIT
// Sides of materials and shadings: written if any has only a front, read back, refused if invalid.
#include "tests.h"

#include "draw/support_store.h"
#include "store/file/sides.h"
#include "store/file/store_state.h"
#include "store/file/tables.h"

static void make_scene(made_scene* scene)
{
    *scene = (made_scene){
        .material_count = 2, .shading_count = 2, .mesh_count = 2, .part_count = 2, .node_count = 1};
    for (uint32_t i = 0; i < 2; ++i) {
        scene->materials[i] = made_material();
        scene->shadings[i] = (stp_shading){.roughness = 1};
        scene->meshes[i] = made_square(i);
        scene->parts[i] = (stp_store_part){STP_STORE_PART_MESH, i};
    }
    scene->nodes[0] = (stp_store_node){.part_count = 2,
                                       .set = STP_STORE_NONE,
                                       .triangle_count = 4,
                                       .bounds = {{-1, -1, 0}, {1, 1, 0}}};
}

void test_sides_are_read_as_written(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    static made_scene scene;
    make_scene(&scene);
    stp_store* store = made_open(context, &scene); // nothing to tell: no section
    CHECK(store != NULL && store->known[STP_SECTION_SIDES] == NULL);
    CHECK_EQUAL(0, stp_store_get_side_figures(store).triangles);
    stp_store_close(store);
    scene.materials[1].flags = STP_SHADING_FRONT_ONLY | STP_SHADING_UNLIT;
    scene.materials[1].inverted = 3;
    scene.shadings[0].flags = STP_SHADING_FRONT_ONLY;
    store = made_open(context, &scene);
    CHECK(store != NULL && store->known[STP_SECTION_SIDES] != NULL);
    CHECK((store->known[STP_SECTION_SIDES]->flags & STP_SECTION_CRITICAL) == 0); // may be skipped
    const stp_store_directory* d = stp_store_get_directory(store);
    CHECK_EQUAL(0, d->materials[0].flags & STP_SHADING_FRONT_ONLY);
    CHECK_EQUAL(STP_SHADING_FRONT_ONLY | STP_SHADING_UNLIT, d->materials[1].flags);
    CHECK_EQUAL(3, d->materials[1].inverted);
    CHECK_EQUAL(STP_SHADING_FRONT_ONLY, d->shadings[0].flags);
    CHECK_EQUAL(0, d->shadings[1].flags);
    stp_store_side_figures figures = stp_store_get_side_figures(store);
    CHECK(figures.materials == 1 && figures.triangles == 2 && figures.inverted == 3);
    stp_store_close(store);
    stp_context_destroy(context);
}

/// A store of four records, of two materials and two shadings.
static stp_store* open_scene(stp_context* context)
{
    static made_scene scene;
    make_scene(&scene);
    scene.materials[0].flags = scene.materials[1].flags = STP_SHADING_FRONT_ONLY;
    return made_open(context, &scene);
}

void test_invalid_sides_are_refused(test_state* test)
{
    for (int way = 0; way < 12; ++way) {
        test_log log = {.errors = 0};
        stp_context* context = test_context(NULL, 1, &log);
        stp_store* store = open_scene(context);
        CHECK(store != NULL);
        stp_store_sides* records = store->tables[STP_SECTION_SIDES];
        CHECK_EQUAL(4, store->counts[STP_SECTION_SIDES]);
        records[3].flags = way / 2 == 0 ? 2 : 0;
        store->counts[STP_SECTION_SIDES] = way / 2 == 1 ? 3 : way / 2 == 2 ? 0 : 4;
        records[2].triangles = way / 2 == 3 ? 1 : 0; // of a shading
        records[2].inverted = way / 2 == 4 ? 1 : 0;
        if (way % 2 == 0) {
            CHECK_EQUAL(way / 2 < 5 ? STP_ERROR_FORMAT : STP_OK, stp_store_link_sides(store));
        } else { // as for the summary alone: materials and shadings are not read
            store->counts[STP_SECTION_MATERIALS] = store->counts[STP_SECTION_SHADINGS] = 0;
            CHECK_EQUAL(way / 2 < 5 ? STP_ERROR_FORMAT : STP_OK, stp_store_validate_sides(store));
        }
        CHECK_EQUAL(way / 2 < 5 ? 1 : 0, log.errors);
        stp_store_close(store);
        stp_context_destroy(context);
    }
}

void test_figures_of_sides_do_not_wrap(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_store* store = open_scene(context);
    CHECK(store != NULL);
    stp_store_sides* records = store->tables[STP_SECTION_SIDES];
    for (int i = 0; i < 4; ++i) {
        records[i] = (stp_store_sides){.flags = STP_SIDES_FRONT_ONLY, .inverted = 1};
        records[i].triangles = UINT64_MAX - 1;
    }
    stp_store_side_figures figures = stp_store_get_side_figures(store);
    CHECK_EQUAL(UINT64_MAX, figures.triangles);
    CHECK(figures.materials == 2 && figures.inverted == 2); // shadings do not count
    stp_store_close(store);
    stp_context_destroy(context);
}

// SPDX-License-Identifier: MIT
// Levels of triangles that are taken from an earlier output.
#include "support_level_scenes.h"
#include "work_helpers.h"

#include "lod/support_level_shapes.h"

static uint32_t rows; ///< of the second torus of make_pair

/// Many copies of two tori, each of which has levels; of the second in two materials that are
/// shaded differently.
static bool make_pair(stp_scene* scene)
{
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    uint32_t smooth = level_add_material(scene, 0.1f, 0.1f, 0.8f);
    bool good = red != STP_NONE && smooth != STP_NONE;
    if (good) {
        scene->materials[smooth].roughness = 0.25f;
    }
    stp_mesh meshes[3] = {level_torus(scene->context, 60, 40, 1.0, 0.4),
                          level_torus(scene->context, 40, rows, 1.0, 0.3),
                          level_torus(scene->context, 40, 20, 0.5, 0.1)};
    for (int i = 0; i < 3 && good; ++i) {
        uint32_t mesh;
        const stp_object prototype = {
            .parent = STP_NONE, .transform = stp_affine_identity(), .flags = STP_OBJECT_PROTOTYPE};
        meshes[i].material = i == 2 ? smooth : red;
        good = stp_scene_add_mesh(scene, &meshes[i], &mesh) == STP_OK &&
               (i == 2 || stp_scene_add_object(scene, &prototype, NULL) == STP_OK) &&
               stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK;
    }
    return good && level_scene_add_copies(scene);
}

typedef struct output {
    unsigned char* bytes;
    size_t size;
} output;

static bool read_output(stp_context* context, const char* path, output* o)
{
    stp_mapped_file file;
    if (stp_file_map(context, path, &file) != STP_OK) {
        return false;
    }
    o->size = file.size;
    o->bytes = stp_alloc(context, file.size);
    if (o->bytes != NULL) {
        memcpy(o->bytes, file.bytes, file.size);
    }
    stp_file_unmap(&file);
    return o->bytes != NULL;
}

static bool write_output(const char* path, const unsigned char* bytes, size_t size)
{
    FILE* file = fopen(path, "wb");
    bool written = file != NULL && fwrite(bytes, 1, size, file) == size;
    return file != NULL && fclose(file) == 0 && written;
}

static bool is_same(const output* a, const output* b)
{
    return a->size == b->size && memcmp(a->bytes, b->bytes, a->size) == 0;
}

/// Builds over what is at `path`, and reads the result.
static bool build_output(stp_context* context, const char* path, bool fresh,
                         stp_build_report* report, output* o)
{
    const level_build build = {.make = make_pair, .no_splats = true, .fresh = fresh};
    return level_build_to(context, &build, path, report) == STP_OK && read_output(context, path, o);
}

void test_unchanged_levels_are_found_in_the_former_output(test_state* test)
{
    char folder[64] = "stp_found_XXXXXX", path[96];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_build_report report;
    output first, again, changed, fresh;
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/one.stip", folder);
    rows = 30;
    CHECK(build_output(context, path, false, &report, &first));
    CHECK(report.levels_made == 2 && report.levels_found == 0);
    CHECK(build_output(context, path, false, &report, &again));
    CHECK(report.levels_made == 0 && report.levels_found == 2);
    CHECK(is_same(&first, &again));
    rows = 34;
    CHECK(build_output(context, path, false, &report, &changed));
    CHECK(report.levels_made == 1 && report.levels_found == 1);
    CHECK(build_output(context, path, true, &report, &fresh));
    CHECK(report.levels_made == 2 && report.levels_found == 0);
    CHECK(is_same(&changed, &fresh));
    CHECK(!is_same(&changed, &first));
    stp_free(context, first.bytes);
    stp_free(context, again.bytes);
    stp_free(context, changed.bytes);
    stp_free(context, fresh.bytes);
    CHECK(unlink(path) == 0 && rmdir(folder) == 0);
    stp_context_destroy(context);
}

void test_levels_of_damaged_former_outputs_are_made_again(test_state* test)
{
    char folder[64] = "stp_found_XXXXXX", path[96];
    stp_context* context = test_context(NULL, 2, NULL);
    stp_build_report report;
    output good, again;
    uint32_t found = 0, made = 0;
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/one.stip", folder);
    rows = 30;
    CHECK(build_output(context, path, false, &report, &good));
    unsigned char* damaged = stp_alloc(context, good.size);
    CHECK(damaged != NULL);
    for (size_t step = good.size / 23, at = step / 2; at < good.size; at += step) {
        memcpy(damaged, good.bytes, good.size);
        damaged[at] ^= 0x21;
        CHECK(write_output(path, damaged, at / step % 4 == 3 ? at : good.size));
        CHECK(build_output(context, path, false, &report, &again));
        CHECK(is_same(&good, &again));
        found += report.levels_found;
        made += report.levels_made;
        stp_free(context, again.bytes);
    }
    CHECK(found > 0 && made > 0);
    stp_free(context, damaged);
    stp_free(context, good.bytes);
    CHECK(unlink(path) == 0 && rmdir(folder) == 0);
    stp_context_destroy(context);
}

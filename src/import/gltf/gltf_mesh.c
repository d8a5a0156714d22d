// SPDX-License-Identifier: MIT
// Reads all visible primitives in jobs and adds them to the scene in file order.
#include "import/gltf/gltf_primitive.h"
#include "import/reading/smooth.h"

#include <assert.h>
#include <string.h>

#define ELEMENTS_OF_BATCH ((uint64_t)1 << 21) // vertices and indices
#define ELEMENT_BYTES 64u                     // about the size of a vertex with all attributes

typedef struct primitive_loop {
    const stp_gltf* gltf;
    stp_gltf_primitive* primitives; ///< the first of the loop
} primitive_loop;

static char* copy_message(stp_context* context, const char* message)
{
    size_t size = strlen(message) + 1;
    char* copy = size > 1 ? stp_alloc(context, size) : NULL;
    return copy != NULL ? memcpy(copy, message, size) : NULL;
}

static void set_place(stp_gltf_scope* scope, const stp_gltf_primitive* primitive)
{
    assert(primitive->variant < scope->gltf->variant_count);
    assert(primitive->index < scope->gltf->variants[primitive->variant].primitive_count);
    stp_gltf_set_place(scope, "meshes[%u].primitives[%zu]",
                       scope->gltf->variants[primitive->variant].mesh, primitive->index);
}

static void read_job(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    primitive_loop* loop = user;
    for (size_t i = begin; i < end; ++i) {
        stp_gltf_primitive* primitive = &loop->primitives[i];
        stp_gltf_scope scope = stp_gltf_scope_begin(loop->gltf);
        set_place(&scope, primitive);
        primitive->result = stp_gltf_read_primitive(&scope, primitive);
        primitive->error = copy_message(loop->gltf->context, scope.error);
        primitive->warning = copy_message(loop->gltf->context, scope.warning);
    }
}

static stp_result count_primitives(stp_gltf_scope* scope, stp_gltf* gltf, size_t* count)
{
    *count = 0;
    for (size_t i = 0; i < gltf->variant_count; ++i) {
        stp_gltf_variant* variant = &gltf->variants[i];
        const json_t *mesh, *primitives;
        stp_gltf_set_place(scope, "meshes[%u]", variant->mesh);
        stp_result result = stp_gltf_item(scope, STP_GLTF_MESHES, variant->mesh, &mesh);
        if (result == STP_OK) {
            result = stp_gltf_array(scope, mesh, "primitives", &primitives);
        }
        if (result != STP_OK) {
            return result;
        }
        variant->first_primitive = *count;
        variant->primitive_count = json_array_size(primitives);
        *count += variant->primitive_count;
    }
    stp_gltf_set_place(scope, "%s", "");
    return STP_OK;
}

static void plan_primitives(const stp_gltf* gltf, stp_gltf_primitive* primitives)
{
    for (size_t i = 0; i < gltf->variant_count; ++i) {
        const stp_gltf_variant* variant = &gltf->variants[i];
        for (size_t k = 0; k < variant->primitive_count; ++k) {
            primitives[variant->first_primitive + k] =
                (stp_gltf_primitive){.variant = i, .index = k};
        }
    }
}

static stp_result add_primitive(stp_gltf* gltf, stp_gltf_primitive* primitive, stp_gltf_part* part)
{
    stp_scene* scene = gltf->import->scene;
    assert(!primitive->present || primitive->result == STP_OK);
    part->present = primitive->present;
    if (!primitive->present) {
        return STP_OK;
    }
    if (primitive->mode == STP_GLTF_POINTS) {
        stp_point_set points = primitive->points;
        primitive->points = (stp_point_set){0}; // the scene takes it, also on failure
        part->part.kind = STP_PART_POINTS;
        return stp_scene_add_point_set(scene, &points, &part->part.index);
    }
    stp_mesh mesh = primitive->mesh;
    primitive->mesh = (stp_mesh){0};
    part->part.kind = STP_PART_MESH;
    return stp_import_add_mesh(gltf->import, &mesh, &part->part.index);
}

// Logs the messages of primitives [begin, end), adds them to the scene, and counts those of lines.
static stp_result add_primitives(stp_gltf_scope* scope, stp_gltf* gltf,
                                 stp_gltf_primitive* primitives, size_t begin, size_t end,
                                 size_t* line_count)
{
    for (size_t i = begin; i < end; ++i) {
        stp_gltf_primitive* primitive = &primitives[i];
        if (primitive->warning != NULL) {
            stp_warn(gltf->context, "%s: %s", gltf->import->path, primitive->warning);
        }
        if (primitive->result != STP_OK && primitive->error != NULL) {
            return stp_gltf_logged(scope, stp_fail(gltf->context, primitive->result, "%s: %s",
                                                   gltf->import->path, primitive->error));
        }
        if (primitive->result != STP_OK) {
            return STP_ERROR_OUT_OF_MEMORY; // the only failure without a message
        }
        *line_count += primitive->mode >= STP_GLTF_LINES && primitive->mode <= STP_GLTF_LINE_STRIP;
        stp_result result = stp_gltf_logged(scope, add_primitive(gltf, primitive, &gltf->parts[i]));
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

// End of the primitives that are read together: at least one, until a batch's elements are reached.
static size_t end_batch(const stp_gltf* gltf, const stp_gltf_primitive* primitives, size_t begin,
                        size_t count)
{
    size_t end = begin;
    uint64_t elements = 0, maximum = stp_gltf_batch(gltf, ELEMENTS_OF_BATCH, ELEMENT_BYTES);
    while (end < count && (end == begin || elements < maximum)) {
        const stp_gltf_variant* variant = &gltf->variants[primitives[end].variant];
        elements += stp_gltf_primitive_elements(gltf, variant, primitives[end].index);
        end += 1;
    }
    assert(end > begin && end <= count);
    return end;
}

// Works in batches: the scene may move a batch out of memory before the next one is read, and the
// file content read for it is released.
static stp_result read_primitives(stp_gltf_scope* scope, stp_gltf* gltf,
                                  stp_gltf_primitive* primitives, size_t count)
{
    size_t line_count = 0;
    stp_result result = STP_OK;
    for (size_t begin = 0; result == STP_OK && begin < count;) {
        size_t end = end_batch(gltf, primitives, begin, count);
        primitive_loop loop = {.gltf = gltf, .primitives = primitives + begin};
        stp_parallel_for(gltf->context, end - begin, 1, read_job, &loop);
        result = add_primitives(scope, gltf, primitives, begin, end, &line_count);
        stp_gltf_release_buffers(gltf);
        begin = end;
    }
    stp_losses_add(&gltf->import->losses, STP_LOSS_LINE, line_count);
    return result;
}

// A mesh has as many morph targets as each of its primitives.
static void count_morph_targets(stp_gltf* gltf)
{
    size_t count = stp_gltf_count(gltf, STP_GLTF_MESHES);
    for (size_t i = 0; i < count; ++i) {
        const json_t* mesh = json_array_get(gltf->lists[STP_GLTF_MESHES], i);
        const json_t* first = json_array_get(json_object_get(mesh, "primitives"), 0);
        stp_losses_add(&gltf->import->losses, STP_LOSS_MORPH,
                       json_array_size(json_object_get(first, "targets")));
    }
}

stp_result stp_gltf_load_meshes(stp_gltf_scope* scope, stp_gltf* gltf)
{
    count_morph_targets(gltf);
    size_t count;
    stp_result result = count_primitives(scope, gltf, &count);
    if (result == STP_OK) {
        result = stp_gltf_check_meshes(scope, gltf);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_gltf_primitive* primitives = STP_NEW_ZEROED(gltf->context, stp_gltf_primitive, count);
    gltf->parts = STP_NEW_ZEROED(gltf->context, stp_gltf_part, count);
    if (primitives == NULL || gltf->parts == NULL) {
        stp_free(gltf->context, primitives);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    plan_primitives(gltf, primitives);
    result = read_primitives(scope, gltf, primitives, count);
    for (size_t i = 0; i < count; ++i) {
        stp_gltf_free_primitive(gltf->context, &primitives[i]);
    }
    stp_free(gltf->context, primitives);
    return result;
}

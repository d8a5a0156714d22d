// SPDX-License-Identifier: MIT
#include "store/file/validate.h"

#include "base/splats/splat_codes.h"
#include "store/bytes/columns.h"

#include <assert.h>
#include <stdio.h>

static bool is_reference(uint32_t index, uint32_t count)
{
    return index == STP_STORE_NONE || index < count;
}

static bool is_range(uint32_t first, uint32_t size, uint32_t count)
{
    return first <= count && size <= count - first;
}

static stp_result check_nodes(const stp_store_validator* validator,
                              const stp_store_directory* directory)
{
    uint64_t edges = 0, parts = 0;
    for (uint32_t i = 0; i < directory->node_count; ++i) {
        const stp_store_node* node = &directory->nodes[i];
        // overlapping ranges would let a small file cause quadratic work
        edges += node->edge_count;
        parts += node->part_count;
        if (!is_range(node->first_edge, node->edge_count, directory->edge_count) ||
            edges > directory->edge_count) {
            return stp_fail(validator->context, validator->failure,
                            "%s: node %u: its edges exceed the count of %u", validator->path, i,
                            directory->edge_count);
        }
        if (!is_range(node->first_part, node->part_count, directory->part_count) ||
            parts > directory->part_count) {
            return stp_fail(validator->context, validator->failure,
                            "%s: node %u: its parts exceed the count of %u", validator->path, i,
                            directory->part_count);
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = directory->edges[node->first_edge + k].node;
            if (child >= i) {
                return stp_fail(validator->context, validator->failure,
                                "%s: node %u: its edge to node %u does not lead to a lower index",
                                validator->path, i, child);
            }
        }
        if (!is_reference(node->set, directory->set_count)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: node %u: splat set %u does not exist (there are %u)",
                            validator->path, i, node->set, directory->set_count);
        }
        if (node->flags > 1) {
            return stp_fail(validator->context, validator->failure,
                            "%s: node %u: flags %#x are not defined in this version",
                            validator->path, i, node->flags);
        }
    }
    return STP_OK;
}

static stp_result check_edges_and_parts(const stp_store_validator* validator,
                                        const stp_store_directory* directory)
{
    for (uint32_t i = 0; i < directory->edge_count; ++i) {
        if (directory->edges[i].node >= directory->node_count) {
            return stp_fail(validator->context, validator->failure,
                            "%s: edge %u: node %u does not exist (there are %u)", validator->path,
                            i, directory->edges[i].node, directory->node_count);
        }
    }
    for (uint32_t i = 0; i < directory->part_count; ++i) {
        stp_store_part part = directory->parts[i];
        bool is_mesh = part.kind == STP_STORE_PART_MESH;
        uint32_t count = is_mesh ? directory->mesh_count : directory->point_set_count;
        if ((!is_mesh && part.kind != STP_STORE_PART_POINTS) || part.index >= count) {
            return stp_fail(validator->context, validator->failure,
                            "%s: part %u: kind %u, index %u does not exist", validator->path, i,
                            (unsigned)part.kind, part.index);
        }
    }
    return STP_OK;
}

static stp_result check_materials(const stp_store_validator* validator,
                                  const stp_store_directory* directory)
{
    for (uint32_t i = 0; i < directory->material_count; ++i) {
        const stp_store_material* material = &directory->materials[i];
        const stp_store_texture_use* uses[] = {
            &material->base_color_texture, &material->metallic_roughness_texture,
            &material->emissive_texture, &material->normal_texture};
        int use_count = material->normal_scale != 0.0f ? 4 : 3;
        for (int k = 0; k < use_count; ++k) {
            if (!is_reference(uses[k]->texture, directory->texture_count) ||
                uses[k]->texcoord > 1) {
                return stp_fail(validator->context, validator->failure,
                                "%s: material %u: texture %u with coordinates %u does not exist",
                                validator->path, i, uses[k]->texture, uses[k]->texcoord);
            }
        }
        if (!isfinite(material->normal_scale)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: material %u: the scale of its normal map is not finite",
                            validator->path, i);
        }
        if ((material->flags & ~(uint32_t)STP_SHADING_FRONT_ONLY) > 3 ||
            (uint32_t)material->alpha > STP_STORE_BLEND) {
            return stp_fail(
                validator->context, validator->failure,
                "%s: material %u: flags %#x, alpha mode %u are not defined in this version",
                validator->path, i, material->flags, (unsigned)material->alpha);
        }
    }
    if (directory->shading_count > STP_STORE_SHADING_LIMIT) {
        return stp_fail(validator->context, validator->failure, "%s: has %u shadings, more than %d",
                        validator->path, directory->shading_count, STP_STORE_SHADING_LIMIT);
    }
    for (uint32_t i = 0; i < directory->shading_count; ++i) {
        if ((directory->shadings[i].flags & ~(uint32_t)STP_SHADING_FRONT_ONLY) > 7) {
            return stp_fail(validator->context, validator->failure,
                            "%s: shading %u: flags %#x are not defined in this version",
                            validator->path, i, directory->shadings[i].flags);
        }
    }
    return STP_OK;
}

stp_result stp_store_validate_graph(const stp_store_validator* validator,
                                    const stp_store_directory* directory)
{
    assert(validator->failure != STP_OK && "a fault must fail the call");
    stp_result result = check_nodes(validator, directory);
    if (result == STP_OK) {
        result = check_edges_and_parts(validator, directory);
    }
    if (result == STP_OK) {
        result = check_materials(validator, directory);
    }
    if (result == STP_OK && !is_reference(directory->root, directory->node_count)) {
        result = stp_fail(validator->context, validator->failure,
                          "%s: root node %u does not exist (there are %u)", validator->path,
                          directory->root, directory->node_count);
    }
    if (result == STP_OK && !(directory->unit_metres >= 0.0 && isfinite(directory->unit_metres))) {
        result =
            stp_fail(validator->context, validator->failure, "%s: a unit of %g metres is invalid",
                     validator->path, directory->unit_metres);
    }
    if (result == STP_OK && (directory->up < 'x' || directory->up > 'z')) {
        result = stp_fail(validator->context, validator->failure,
                          "%s: the up axis is not x, y or z", validator->path);
    }
    return result;
}

stp_result stp_store_validate_objects(const stp_store_validator* validator,
                                      const stp_store_directory* directory)
{
    assert(validator->failure != STP_OK && "a fault must fail the call");
    for (uint32_t i = 0; i < directory->object_count; ++i) {
        const stp_store_object* object = &directory->objects[i];
        if (!is_reference(object->parent, i)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: object %u: parent %u does not have a lower index", validator->path,
                            i, object->parent);
        }
        if (!is_reference(object->node, directory->node_count)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: object %u: node %u does not exist (there are %u)", validator->path,
                            i, object->node, directory->node_count);
        }
    }
    return STP_OK;
}

stp_result stp_store_validate_material(const stp_store_validator* validator, const char* what,
                                       uint32_t index, uint32_t material, uint32_t material_count)
{
    if (material >= material_count) {
        return stp_fail(validator->context, validator->failure,
                        "%s: %s %u: material %u does not exist (there are %u)", validator->path,
                        what, index, material, material_count);
    }
    return STP_OK;
}

stp_result stp_store_validate_texture(const stp_store_validator* validator, uint32_t index,
                                      const stp_store_texture* texture)
{
    if (texture->width == 0 || texture->height == 0 || texture->width > STP_STORE_TEXTURE_LIMIT ||
        texture->height > STP_STORE_TEXTURE_LIMIT) {
        return stp_fail(validator->context, validator->failure,
                        "%s: texture %u: %u x %u texels are not between 1 and %d", validator->path,
                        index, texture->width, texture->height, STP_STORE_TEXTURE_LIMIT);
    }
    if (texture->wrap_u > 2 || texture->wrap_v > 2 || texture->nearest > 1) {
        return stp_fail(
            validator->context, validator->failure,
            "%s: texture %u: wrap modes %u, %u or filter %u are not defined in this version",
            validator->path, index, texture->wrap_u, texture->wrap_v, texture->nearest);
    }
    return STP_OK;
}

static bool is_power_of_two(float step)
{
    int exponent = 0;
    return step > 0.0f && frexpf(step, &exponent) == 0.5f;
}

// The prefix table: counts ascend from 1 up to the set's count, radii do not ascend.
static bool is_table(const stp_prefix_table* table, uint32_t count)
{
    bool good = table->size <= STP_PREFIX_TABLE_SIZE;
    for (uint32_t i = 0; good && i < table->size; ++i) {
        good = table->radius[i] >= 0.0f && isfinite(table->radius[i]) && table->count[i] >= 1 &&
               table->count[i] <= count;
        if (good && i > 0) {
            good =
                table->count[i] > table->count[i - 1] && table->radius[i] <= table->radius[i - 1];
        }
    }
    return good;
}

static bool are_octaves(const stp_splats* splats)
{
    uint32_t octaves = splats->octave_count;
    if (octaves > STP_OCTAVE_LIMIT || (octaves == 0) != (splats->count == 0)) {
        return false;
    }
    bool good = octaves == 0 || splats->octave_ends[octaves - 1] == splats->count;
    for (uint32_t i = 0; good && i < octaves; ++i) {
        good = splats->octave_ends[i] > stp_store_octave_begin(splats, i);
    }
    return good;
}

static bool is_radius(float radius)
{
    return radius >= 0.0f && isfinite(radius);
}

const char* stp_store_splat_set_fault(const stp_splats* splats)
{
    const char* fault = NULL;
    float reach = splats->step * 65535.0f;
    if (!are_octaves(splats)) {
        fault = "octave ends do not ascend to its count";
    } else if (!is_table(&splats->table, splats->count)) {
        fault = "the prefix table is not monotone";
    } else if (splats->count != 0 && !is_power_of_two(splats->step)) {
        fault = "the step of its grid is not a power of two";
    } else if (splats->count != 0 &&
               !(isfinite(splats->origin.x + reach) && isfinite(splats->origin.y + reach) &&
                 isfinite(splats->origin.z + reach))) {
        fault = "positions of its grid are not finite";
    } else if (!is_radius(splats->candidate_radius) || !is_radius(splats->paper_radius)) {
        fault = "a radius is negative or not finite";
    } else if ((splats->columns & STP_SPLATS_SHAPES) != 0 &&
               !isfinite(splats->step * stp_shape_radius(STP_SHAPE_NOT_FINITE))) {
        fault = "radii of its splats are not finite";
    } else if (splats->paper_count > splats->count) {
        fault = "its paper count exceeds its count";
    } else if (splats->light_octaves != 0 &&
               (splats->columns != 0 || splats->light_octaves >> splats->octave_count != 0)) {
        fault = "light normals are of other octaves than its own, or beside other columns";
    }
    return fault;
}

stp_result stp_store_validate_splat_set(const stp_store_validator* validator, uint32_t index,
                                        const stp_splats* splats)
{
    const char* fault = stp_store_splat_set_fault(splats);
    if (fault != NULL) {
        return stp_fail(validator->context, validator->failure, "%s: splat set %u: %s",
                        validator->path, index, fault);
    }
    return STP_OK;
}

stp_result stp_store_validate_leaves(const stp_store_validator* validator, uint32_t index,
                                     const stp_splats* splats)
{
    const char* fault = splats->leaf_count == 0 ? NULL
                        : splats->leaves == NULL
                            ? "its leaves are missing"
                            : stp_splat_leaves_fault(splats, splats->leaves, splats->leaf_count);
    if (fault != NULL) {
        return stp_fail(validator->context, validator->failure, "%s: splat set %u: %s",
                        validator->path, index, fault);
    }
    return STP_OK;
}

// Index of the first number that is not finite; `count` if all are finite.
static uint64_t find_not_finite(const float* numbers, uint64_t count)
{
    if (numbers == NULL) {
        return count;
    }
    for (uint64_t i = 0; i < count; ++i) {
        if (!isfinite(numbers[i])) {
            return i;
        }
    }
    return count;
}

static stp_result report_fault(const stp_store_validator* validator, const char* format, ...)
    __attribute__((format(printf, 2, 3)));

static stp_result report_fault(const stp_store_validator* validator, const char* format, ...)
{
    char message[1024];
    assert(validator->failure != STP_OK && "a fault must fail the call");
    va_list list;
    va_start(list, format);
    vsnprintf(message, sizeof(message), format, list);
    va_end(list);
    if (validator->warns) {
        stp_warn(validator->context, "%s", message);
        return validator->failure;
    }
    return stp_fail(validator->context, validator->failure, "%s", message);
}

stp_result stp_store_validate_mesh_data(const stp_store_validator* validator, uint32_t index,
                                        const stp_store_mesh* mesh)
{
    uint64_t vertices = mesh->vertex_count;
    uint64_t bad = find_not_finite(mesh->positions, 3 * vertices);
    if (bad < 3 * vertices) {
        return report_fault(validator, "%s: mesh %u: the position of vertex %llu is not finite",
                            validator->path, index, (unsigned long long)(bad / 3));
    }
    for (int set = 0; set < 2; ++set) {
        bad = find_not_finite(mesh->texcoords[set], 2 * vertices);
        if (bad < 2 * vertices) {
            return report_fault(validator,
                                "%s: mesh %u: texture coordinates of vertex %llu are not finite",
                                validator->path, index, (unsigned long long)(bad / 2));
        }
    }
    uint64_t corners = 3 * (uint64_t)mesh->triangle_count;
    uint32_t highest = 0;
    for (uint64_t i = 0; i < corners; ++i) {
        highest = mesh->indices[i] > highest ? mesh->indices[i] : highest;
    }
    if (corners != 0 && highest >= mesh->vertex_count) {
        return report_fault(validator, "%s: mesh %u: index %u is not below its vertex count %u",
                            validator->path, index, highest, mesh->vertex_count);
    }
    return STP_OK;
}

stp_result stp_store_validate_point_data(const stp_store_validator* validator, uint32_t index,
                                         const stp_store_point_set* points)
{
    uint64_t numbers = 3 * (uint64_t)points->point_count;
    uint64_t bad = find_not_finite(points->positions, numbers);
    if (bad < numbers) {
        return report_fault(validator, "%s: point set %u: the position of point %llu is not finite",
                            validator->path, index, (unsigned long long)(bad / 3));
    }
    return STP_OK;
}

/// For methods whose sets can be the points themselves: `blue` has no columns, `stochastic` both.
enum { HOLDING_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_FLAT_COLORS };

stp_result stp_store_validate_held_points(const stp_store_validator* validator, uint32_t index,
                                          const stp_store_point_set* points, const stp_splats* set)
{
    if ((set->columns & ~(uint32_t)HOLDING_COLUMNS) != 0 || set->count != points->point_count) {
        return report_fault(validator,
                            "%s: point set %u has %u points, but its splat set has %u splats",
                            validator->path, index, points->point_count, set->count);
    }
    return STP_OK;
}

stp_result stp_store_validate_splat_data(const stp_store_validator* validator, uint32_t index,
                                         const stp_store_splat_data* data, uint32_t shading_count)
{
    uint8_t highest = 0;
    for (uint64_t i = 0; i < data->count; ++i) {
        highest = data->materials[i] > highest ? data->materials[i] : highest;
    }
    if (data->count != 0 && highest >= shading_count) {
        return report_fault(validator, "%s: splat set %u: shading %u does not exist (there are %u)",
                            validator->path, index, highest, shading_count);
    }
    for (uint64_t i = 0; data->shapes != NULL && i < data->count; ++i) {
        if (!stp_shape_is_valid(data->shapes[i])) {
            return report_fault(
                validator, "%s: splat set %u: a radius is not finite, or the smaller one is larger",
                validator->path, index);
        }
    }
    for (uint64_t i = 0; data->ranges != NULL && i < data->count; ++i) {
        if (!stp_range_is_valid(data->ranges[i])) {
            return report_fault(validator, "%s: splat set %u: a lowest level exceeds the highest",
                                validator->path, index);
        }
    }
    return STP_OK;
}

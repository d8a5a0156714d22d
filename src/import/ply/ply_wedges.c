// SPDX-License-Identifier: MIT
// Faces with colours or texture coordinates of their own: corners that agree in all of these become
// one vertex, and the faces of each picture a mesh.
#include "import/ply/ply.h"
#include "import/reading/triangulate.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static const stp_ply_property* find_property(const stp_ply_element* element, const char* words,
                                             bool is_list)
{
    for (size_t i = 0; i < element->property_count; ++i) {
        const stp_ply_property* property = &element->properties[i];
        if (property->is_list == is_list && stp_ply_is_one_of(property->name, words)) {
            return property;
        }
    }
    return NULL;
}

void stp_ply_wedges_begin_element(stp_ply_wedges* w, const stp_ply_element* element)
{
    bool colored = stp_ply_find_colors(element, &w->colors);
    w->has_colors = colored && w->wants_colors;
    w->texcoord = w->ply->texture_count > 0
                      ? find_property(element, "texcoord texcoords uv texture_uv", true)
                      : NULL;
    w->texnumber = find_property(element, "texnumber texture_number", false);
}

stp_result stp_ply_wedges_begin(stp_ply_wedges* w, const stp_ply* ply, bool vertices_have_colors)
{
    *w = (stp_ply_wedges){.ply = ply, .wants_colors = !vertices_have_colors};
    for (size_t i = 0; i < ply->element_count; ++i) {
        const stp_ply_element* element = &ply->elements[i];
        if (element->count > 0 && strcmp(element->name, "face") == 0) {
            stp_ply_wedges_begin_element(w, element);
            w->any_colors |= w->has_colors;
            w->any_texcoords |= w->texcoord != NULL;
        }
    }
    w->active = w->any_colors || w->any_texcoords;
    if (w->active) {
        w->group_count = ply->texture_count + 1;
        w->groups = STP_NEW_ZEROED(ply->context, stp_ply_group, w->group_count);
    }
    for (size_t i = 0; w->groups != NULL && i < w->group_count; ++i) {
        w->groups[i].known.context = ply->context;
    }
    return !w->active || w->groups != NULL ? STP_OK : stp_fail_memory(ply->context);
}

void stp_ply_wedges_end(stp_ply_wedges* w)
{
    for (size_t i = 0; w->groups != NULL && i < w->group_count; ++i) {
        stp_lookup_destroy(&w->groups[i].known);
        stp_free(w->ply->context, w->groups[i].wedges);
        stp_free(w->ply->context, w->groups[i].indices);
    }
    if (w->ply != NULL) {
        void* arrays[] = {w->groups, w->texcoords, w->places, w->numbers, w->vertices};
        for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
            stp_free(w->ply->context, arrays[i]);
        }
    }
    *w = (stp_ply_wedges){0};
}

// Types and scale of colours may differ between elements, so that elements share no vertices.
void stp_ply_wedges_end_element(stp_ply_wedges* w)
{
    stp_ply_color_scale scale = stp_ply_find_color_scale(&w->colors);
    for (size_t i = 0; i < w->group_count; ++i) {
        stp_ply_group* group = &w->groups[i];
        for (; group->scaled < group->count; ++group->scaled) {
            float* color = group->wedges[group->scaled].color;
            for (size_t k = 0; k < 4; ++k) {
                color[k] = stp_ply_scaled_color(&scale, k, color[k]);
            }
        }
        stp_lookup_destroy(&group->known);
    }
}

void stp_ply_wedges_begin_face(stp_ply_wedges* w)
{
    w->texcoord_count = 0;
    w->texture = w->texcoord != NULL ? 0.0 : -1.0;
    for (int i = 0; i < 4; ++i) {
        w->color[i] = INFINITY; // at least white on every scale
    }
}

static stp_result read_texcoords(stp_ply_wedges* w, stp_ply_cursor* cursor, bool* good)
{
    uint64_t count;
    *good = stp_ply_next_list(cursor, w->texcoord, &count);
    if (!*good) {
        return STP_OK;
    }
    if (!STP_MAKE_ROOM(w->ply->context, w->texcoords, w->texcoord_capacity, (size_t)count)) {
        return stp_fail_memory(w->ply->context);
    }
    for (uint64_t i = 0; i < count && *good; ++i) {
        double value;
        *good = stp_ply_next(cursor, w->texcoord->type, &value);
        w->texcoords[i] = *good && isfinite((float)value) ? (float)value : 0.0f;
    }
    w->texcoord_count = (size_t)count;
    return STP_OK;
}

stp_result stp_ply_wedges_read(stp_ply_wedges* w, stp_ply_cursor* cursor,
                               const stp_ply_property* property, bool* good)
{
    if (property == w->texcoord) {
        return read_texcoords(w, cursor, good);
    }
    int channel = 0;
    while (channel < 4 && w->colors.slots[channel] != property) {
        channel += 1;
    }
    if (property != w->texnumber && (channel == 4 || !w->has_colors)) {
        *good = stp_ply_skip(cursor, property);
        return STP_OK;
    }
    double value;
    *good = stp_ply_next(cursor, property->type, &value);
    if (*good && property == w->texnumber) {
        w->texture = value;
    } else if (*good) {
        w->color[channel] = (float)value;
        stp_ply_note_color(&w->colors, channel, value);
    }
    return STP_OK;
}

// The number of a corner's vertex within its group.
static stp_result find_wedge(stp_ply_wedges* w, stp_ply_group* group, const stp_ply_wedge* wedge,
                             uint32_t* number)
{
    uint32_t fresh = (uint32_t)group->count;
    stp_result result = stp_lookup_add(&group->known, wedge, sizeof(*wedge), fresh, number);
    if (result != STP_OK || *number != fresh) {
        return result;
    }
    if (!STP_MAKE_ROOM(w->ply->context, group->wedges, group->capacity, group->count + 1)) {
        return stp_fail_memory(w->ply->context);
    }
    group->wedges[group->count++] = *wedge;
    return group->count < STP_NONE
               ? STP_OK
               : stp_fail(w->ply->context, STP_ERROR_LIMIT, "%s: has more than 2^32 vertices",
                          w->ply->import->path);
}

static stp_result find_wedges(stp_ply_wedges* w, stp_ply_group* group, const float* positions,
                              const uint32_t* corners, size_t count)
{
    stp_result result = STP_OK;
    bool textured = w->texcoord_count >= 2 * count;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        stp_ply_wedge wedge = {.vertex = corners[i]};
        if (textured) {
            wedge.texcoord[0] = w->texcoords[2 * i];
            wedge.texcoord[1] = 1.0f - w->texcoords[2 * i + 1];
        }
        memcpy(wedge.color, w->color, sizeof(wedge.color));
        result = find_wedge(w, group, &wedge, &w->vertices[i]);
        w->numbers[i] = (uint32_t)i;
        memcpy(w->places + 3 * i, positions + 3 * (size_t)corners[i], 3 * sizeof(float));
    }
    return result;
}

stp_result stp_ply_wedges_add(stp_ply_wedges* w, const float* positions, const uint32_t* corners,
                              size_t count)
{
    stp_context* context = w->ply->context;
    size_t last = w->group_count - 1; // without a picture
    assert(count >= 3 && count <= UINT32_MAX);
    stp_ply_group* group =
        &w->groups[w->texture >= 0.0 && w->texture < (double)last ? (size_t)w->texture : last];
    if (!STP_MAKE_ROOM(context, w->places, w->place_capacity, 3 * count) ||
        !STP_MAKE_ROOM(context, w->numbers, w->number_capacity, count) ||
        !STP_MAKE_ROOM(context, w->vertices, w->vertex_capacity, count) ||
        !STP_MAKE_ROOM(context, group->indices, group->index_capacity,
                       group->index_count + 3 * (count - 2))) {
        return stp_fail_memory(context);
    }
    stp_result result = find_wedges(w, group, positions, corners, count);
    if (result != STP_OK) {
        return result;
    }
    uint32_t* out = group->indices + group->index_count;
    if (!stp_triangulate(context, w->places, w->numbers, (uint32_t)count, out)) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < 3 * (count - 2); ++i) {
        assert(out[i] < count);
        out[i] = w->vertices[out[i]];
    }
    group->index_count += 3 * (count - 2);
    return STP_OK;
}

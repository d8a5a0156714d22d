// SPDX-License-Identifier: MIT
// Picks at a position in the picture.
#include "embed/model_internal.h"
#include "select/eyes.h"
#include "select/pick_ray.h"
#include "store/file/point_attributes.h"

#include <stipple/pick.h>

#include <assert.h>

static const double snap_pixels = 8.0, point_pixels = 2.0;

/// Attributes of a hit point. Attributes of a streamed callback's file cannot be read.
static stp_result read_values(stp_model* model, const stp_pick* pick, stp_hit* hit)
{
    assert(pick->part.kind == STP_STORE_PART_POINTS && "only points have attributes");
    bool readable = model->source.reserved == NULL;
    uint32_t mask = readable ? stp_store_point_attributes(model->store, pick->part.index) : 0;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < STP_ATTRIBUTES && result == STP_OK; ++i) {
        stp_attribute attribute = (stp_attribute)i;
        double value; // storage for a value of any type
        if ((mask & stp_attribute_bit(attribute)) != 0) {
            result = stp_store_get_point_values(model->store, pick->part.index, attribute,
                                                pick->element, 1, &value);
            hit->values[i] = result == STP_OK ? stp_attribute_number(attribute, &value, 0) : 0.0;
        }
    }
    hit->attributes = mask;
    return result;
}

/// Finds the objects that contain a hit.
static stp_result find_objects(stp_model* model, const stp_pick* pick, stp_hit* hit)
{
    stp_outline* outline;
    stp_outline_item item = {0}, above;
    stp_result result = stp_model_use_outline(model, &outline);
    if (result == STP_OK) {
        result = stp_outline_find(outline, pick->part, &pick->holder.transform, &item);
    }
    hit->object = hit->placed_object = STP_NO_OBJECT;
    for (uint32_t i = item.depth; i > 0 && result == STP_OK; --i) {
        uint32_t object = item.objects[i - 1];
        hit->object = hit->object == STP_NO_OBJECT ? object : hit->object;
        result = stp_outline_item_of(outline, object, &above);
        if (result == STP_OK && stp_model_is_placed(&above)) {
            hit->placed_object = object;
            break;
        }
    }
    return result;
}

static stp_result describe_hit(stp_model* model, const stp_view* view, const stp_pick* pick,
                               stp_hit* hit)
{
    assert(pick->hit && isfinite(pick->distance));
    double base, slope;
    stp_pixel_width(view, &base, &slope);
    double reach = snap_pixels * (base + slope * pick->distance);
    hit->is_point = pick->part.kind == STP_STORE_PART_POINTS;
    hit->distance = pick->distance;
    hit->position = pick->position;
    hit->normal = hit->is_point ? (stp_vec3d){0, 0, 0} : pick->normal;
    hit->snap = (stp_hit_snap)stp_pick_snap(pick, reach, &hit->snapped);
    assert(pick->material < stp_store_get_directory(model->store)->material_count);
    hit->material = stp_store_get_directory(model->store)->materials[pick->material].name;
    stp_result result = find_objects(model, pick, hit);
    return result == STP_OK && hit->is_point ? read_values(model, pick, hit) : result;
}

/// Picks for the function of that name.
static stp_result pick_for(const char* name, stp_model* model, const stp_view* view,
                           const stp_hit_desc* given, double x, double y, stp_hit* hit)
{
    stp_pick pick;
    stp_hit_desc how;
    stp_hit made = {.object = STP_NO_OBJECT, .placed_object = STP_NO_OBJECT};
    stp_result result = STP_CHECK_CALL(model, view);
    result = result == STP_OK ? STP_CHECK_CALL(model, hit) : result;
    result = result == STP_OK ? STP_READ_DESC(model->context, stp_hit_desc, &how, given) : result;
    result = result == STP_OK ? stp_view_check(model->context, view) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_pick_desc desc = {
        .sections = &view->sections, .visibility = model->visibility, .back_faces = how.back_faces};
    bool finite = isfinite(x) && isfinite(y);
    if (!finite || !stp_ray_of_pixel(view, x, y, &desc.ray)) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "%s: the position is not finite, or too far outside", name);
    }
    stp_pixel_width(view, &desc.point_base, &desc.point_slope);
    desc.point_base *= point_pixels;
    desc.point_slope *= point_pixels;
    result = stp_pick_ray(model->context, model->store, &desc, &pick);
    if (result != STP_OK) {
        return result;
    }
    made.hit = pick.hit;
    made.incomplete = pick.incomplete;
    result = pick.hit ? describe_hit(model, view, &pick, &made) : STP_OK;
    if (result == STP_OK) {
        STP_WRITE_INFO(hit, made);
    }
    return result;
}

stp_result stp_model_pick(stp_model* model, const stp_view* view, double x, double y, stp_hit* hit)
{
    return pick_for("stp_model_pick", model, view, NULL, x, y, hit);
}

stp_result stp_model_pick_with(stp_model* model, const stp_view* view, const stp_hit_desc* given,
                               double x, double y, stp_hit* hit)
{
    return pick_for("stp_model_pick_with", model, view, given, x, y, hit);
}
_Static_assert((int)STP_HIT_SNAP_EDGE == (int)STP_SNAP_EDGE &&
                   (int)STP_HIT_SNAP_VERTEX == (int)STP_SNAP_VERTEX,
               "snaps are numbered alike");
_Static_assert((int)STP_ATTRIBUTES <= (int)STP_HIT_ATTRIBUTES, "each attribute has its room");

// SPDX-License-Identifier: MIT
// Describes a model: counts, methods, sources, attributes, views, streaming state.
#include "embed/model_internal.h"
#include "select/camera.h"
#include "store/file/point_attributes.h"

#include <string.h>

static uint32_t attributes_of(const stp_store* store)
{
    uint32_t mask = 0;
    for (uint32_t i = 0; i < STP_ATTRIBUTES; ++i) {
        const void* found = stp_store_find_attribute(store, (stp_attribute)i);
        mask |= found != NULL ? stp_attribute_bit((stp_attribute)i) : 0;
    }
    return mask;
}

stp_result stp_model_get_info(const stp_model* model, stp_model_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    const stp_store* store = model->store;
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_figures* figures = &model->summary.figures;
    stp_model_info made = {
        .format_major = stp_store_format_version(store),
        .format_minor = stp_store_format_minor(store),
        .file_bytes = stp_store_whole_bytes(store),
        .present_bytes = stp_store_file_bytes(store),
        .unit_metres = d->unit_metres,
        .up = d->up,
        .bounds = model->summary.bounds,
        .triangle_count = figures->triangles,
        .point_count = figures->points,
        .splat_count = figures->surfels,
        .stored_triangle_count = figures->unique_triangles,
        .stored_point_count = figures->unique_points,
        .stored_splat_count = figures->unique_surfels,
        .object_count = d->object_count,
        .view_count = d->view_count,
        .method_count = stp_store_offered_methods(d),
        .source_count = d->source_count,
        .material_count = model->summary.material_count,
        .texture_count = d->texture_count,
        .mesh_count = stp_store_first_level_mesh(d),
        .attributes = attributes_of(store),
        .coordinate_system = stp_store_coordinate_system(store),
        .build_json = d->build_json,
    };
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

static stp_result fail_number(const stp_model* model, const char* what, uint32_t number,
                              uint32_t count)
{
    return stp_fail(model->context, STP_ERROR_ARGUMENT, "%s %u does not exist (the model has %u)",
                    what, number, count);
}

stp_result stp_model_get_method(const stp_model* model, uint32_t method, stp_method_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    const stp_store_directory* d = stp_store_get_directory(model->store);
    if (method >= stp_store_offered_methods(d)) {
        return fail_number(model, "method", method, stp_store_offered_methods(d));
    }
    const stp_store_method* m = &d->methods[method];
    stp_method_info made = {.name = m->name, .set_count = m->set_count};
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

stp_result stp_model_get_source(const stp_model* model, uint32_t source, stp_source_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    const stp_store_directory* d = stp_store_get_directory(model->store);
    if (source >= d->source_count) {
        return fail_number(model, "source", source, d->source_count);
    }
    const stp_store_source* s = &d->sources[source];
    stp_source_info made = {.path = s->path,
                            .format = s->format,
                            .bytes = s->bytes,
                            .coordinate_system = s->coordinate_system};
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

stp_result stp_model_get_attribute(const stp_model* model, stp_attribute attribute,
                                   stp_attribute_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    const stp_store_attribute* found = (uint32_t)attribute < STP_ATTRIBUTES
                                           ? stp_store_find_attribute(model->store, attribute)
                                           : NULL;
    if (found == NULL) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT, "no points have attribute %d",
                        (int)attribute);
    }
    stp_attribute_info made = {.count = found->count,
                               .low = found->low,
                               .high = found->high,
                               .low_percentile = found->low_percentile,
                               .high_percentile = found->high_percentile};
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

stp_result stp_model_get_stream(const stp_model* model, stp_stream_info* info)
{
    stp_result called = STP_CHECK_CALL(model, info);
    if (called != STP_OK) {
        return called;
    }
    stp_stream_info made = {0};
    if (model->residency != NULL) {
        stp_residency_stats stats;
        stp_residency_get_stats(model->residency, &stats);
        made = (stp_stream_info){.limit_bytes = stats.limit_bytes,
                                 .resident_bytes = stats.resident_bytes,
                                 .peak_bytes = stats.peak_bytes,
                                 .read_bytes = stats.read_bytes,
                                 .loaded = stats.loaded,
                                 .dropped = stats.dropped,
                                 .damaged = stats.damaged,
                                 .missing = stats.missing,
                                 .loading = stats.loading};
    }
    STP_WRITE_INFO(info, made);
    return STP_OK;
}

const char* stp_model_get_view_name(const stp_model* model, uint32_t view)
{
    const stp_store_directory* d = model != NULL ? stp_store_get_directory(model->store) : NULL;
    return d != NULL && view < d->view_count ? d->views[view].name : NULL;
}

static const stp_store_view* find_view(const stp_store_directory* d, const char* name)
{
    for (uint32_t i = 0; i < d->view_count; ++i) {
        if (name == NULL || (d->views[i].name != NULL && strcmp(d->views[i].name, name) == 0)) {
            return &d->views[i];
        }
    }
    return NULL;
}

stp_result stp_model_get_view(const stp_model* model, const char* name, stp_view* view)
{
    stp_result called = STP_CHECK_CALL(model, view);
    if (called != STP_OK) {
        return called;
    }
    const stp_store_view* stored = find_view(stp_store_get_directory(model->store), name);
    if (view->width == 0 || view->height == 0) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "view: width and height must be set to fit the scene");
    }
    if (stored != NULL) {
        view->eye = stored->eye;
        view->target = stored->target;
        view->up = stored->up;
        view->fov_degrees = stored->fov_degrees;
        return STP_OK;
    }
    name = name != NULL ? name : "iso";
    if (!stp_camera_face(name, view)) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "view %s: is neither a view of the file nor a standard one", name);
    }
    bool lens = view->fov_degrees == 0.0 || (view->fov_degrees >= STP_FOV_DEGREES_MIN &&
                                             view->fov_degrees <= STP_FOV_DEGREES_MAX);
    if (!lens || !(view->ortho_height >= 0.0) || !isfinite(view->ortho_height) ||
        view->sections.count > STP_SECTION_PLANES) {
        return stp_fail(model->context, STP_ERROR_ARGUMENT,
                        "view: its angle, height or number of sections is out of range");
    }
    const stp_farthest_store content = {model->context, model->store, NULL};
    if (model->residency != NULL) { // which data is loaded must not matter
        stp_camera_fit(view, &model->summary.bounds);
    } else {
        stp_camera_fit_store(&content, NULL, view);
    }
    return STP_OK;
}

// SPDX-License-Identifier: MIT
// Opens and closes models.
#include "embed/model_internal.h"
#include "store/file/point_attributes.h"

#include <assert.h>

static stp_result check_desc(stp_context* context, stp_model_desc* desc)
{
    int sources = (desc->path != NULL) + (desc->bytes != NULL) + (desc->read != NULL);
    desc->name = desc->path != NULL ? desc->path : desc->name != NULL ? desc->name : "memory";
    if (sources != 1) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "stp_model_desc: one of path, bytes and read must be set, not %d", sources);
    }
    if (desc->read != NULL && desc->accept_prefix) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "%s: a file behind a callback must be there as a whole", desc->name);
    }
    return STP_OK;
}

static stp_result open_store(stp_model* model, const stp_model_desc* desc)
{
    stp_store_open_desc opening = {.accept_partial = desc->accept_prefix, .defer_objects = true};
    stp_result result = desc->path != NULL ? stp_store_open_with(model->context, desc->path,
                                                                 &opening, &model->store)
                                           : stp_model_open_source(model, desc, &opening);
    if (result != STP_OK) {
        return result;
    }
    const stp_store_summary* summary = stp_store_get_summary(model->store);
    if (summary != NULL) {
        model->summary = *summary;
        return STP_OK;
    }
    result = stp_store_summarise(model->store, &model->summary); // a file of version 1.0
    model->owns_summary = result == STP_OK;
    return result;
}

static stp_result color_points(stp_model* model, const stp_model_desc* desc)
{
    const stp_point_coloring* given = &desc->point_coloring;
    stp_store_coloring coloring = {.by_attribute = given->by_attribute,
                                   .attribute = given->attribute,
                                   .low = given->low,
                                   .high = given->high};
    for (int i = 0; i < 256; ++i) {
        coloring.shown[i] = given->class_hidden[i] == 0;
        coloring.hides = coloring.hides || given->class_hidden[i] != 0;
    }
    if (given->by_attribute) {
        const stp_store_attribute* found =
            (uint32_t)given->attribute < STP_ATTRIBUTES
                ? stp_store_find_attribute(model->store, given->attribute)
                : NULL;
        if (found == NULL) {
            return stp_fail(model->context, STP_ERROR_ARGUMENT,
                            "%s: has no points with the attribute to colour by", desc->name);
        }
        if (given->low == 0.0 && given->high == 0.0) {
            coloring.low = found->low_percentile;
            coloring.high = found->high_percentile;
        }
    }
    return coloring.by_attribute || coloring.hides ? stp_store_set_coloring(model->store, &coloring)
                                                   : STP_OK;
}

/// Starts streaming, and loads the coarsest level of everything.
static stp_result begin_stream(stp_model* model, const stp_model_desc* desc)
{
    assert(model->residency == NULL && desc->stream);
    stp_residency_desc residency = {.limit_bytes = desc->stream_bytes};
    if (desc->read != NULL) {
        residency.read = stp_model_source_read;
        residency.read_user = &model->source;
    }
    stp_result result = stp_residency_create(model->store, &residency, &model->residency);
    while (result == STP_OK && stp_residency_wait(model->residency)) {
        stp_residency_update(model->residency, NULL, 0);
    }
    return result;
}

stp_result stp_model_open(stp_context* context, const stp_model_desc* given, stp_model** model)
{
    stp_model_desc desc;
    if (context == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    stp_result result = STP_CHECK_POINTER(context, model);
    if (result != STP_OK) {
        return result;
    }
    *model = NULL;
    result = STP_READ_DESC(context, stp_model_desc, &desc, given);
    result = result == STP_OK ? check_desc(context, &desc) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_model* made = STP_NEW_ZEROED(context, stp_model, 1);
    if (made == NULL) {
        return stp_fail_memory(context);
    }
    made->context = context;
    result = open_store(made, &desc);
    result = result == STP_OK ? color_points(made, &desc) : result;
    if (result == STP_OK && desc.stream) {
        result = begin_stream(made, &desc);
    }
    if (result != STP_OK) {
        stp_model_close(made);
        return result;
    }
    *model = made;
    return STP_OK;
}

void stp_model_close(stp_model* model)
{
    if (model == NULL) {
        return;
    }
    stp_context* context = model->context;
    if (model->visibility != NULL) {
        stp_visibility_destroy(model->visibility);
    }
    if (model->outline != NULL) {
        stp_outline_destroy(model->outline);
    }
    stp_residency_destroy(model->residency);
    if (model->owns_summary) {
        stp_store_summary_destroy(context, &model->summary);
    }
    stp_store_close(model->store);
    stp_model_source_destroy(context, &model->source);
    stp_free(context, model);
}

// SPDX-License-Identifier: MIT
#include "program/reports/describe.h"

#include <math.h>

stp_result describe_store(stp_context* context, stp_store* store, scene_figures* figures)
{
    *figures = (scene_figures){
        .directory = stp_store_get_directory(store),
        .file_bytes = stp_store_file_bytes(store),
        .whole_bytes = stp_store_whole_bytes(store),
        .format_version = stp_store_format_version(store),
        .format_minor = stp_store_format_minor(store),
        .position_error = stp_store_position_error(store),
        .sides = stp_store_get_side_figures(store),
    };
    const stp_store_level_figures* levels = stp_store_get_level_figures(store);
    figures->levels = levels != NULL ? *levels : (stp_store_level_figures){0};
    figures->has_level_figures = levels != NULL || stp_store_format_minor(store) != 3;
    const stp_store_summary* stored = stp_store_get_summary(store);
    if (stored != NULL) {
        figures->summary = *stored;
        return STP_OK;
    }
    figures->context = context;
    return stp_store_summarise(store, &figures->summary);
}

stp_result describe_content(stp_context* context, const stp_store_content* content,
                            scene_figures* figures)
{
    *figures = (scene_figures){
        .directory = &content->directory, .context = context, .has_level_figures = true};
    for (uint32_t i = 0; i < content->directory.source_count; ++i) {
        figures->file_bytes += content->directory.sources[i].bytes;
    }
    stp_result result = stp_store_side_figures_of_content(context, content, &figures->sides);
    return result == STP_OK ? stp_store_summarise_content(context, content, &figures->summary)
                            : result;
}

void describe_destroy(scene_figures* figures)
{
    if (figures->context != NULL) {
        stp_store_summary_destroy(figures->context, &figures->summary);
    }
    *figures = (scene_figures){0};
}

const char* describe_unit(double metres)
{
    static const struct {
        double metres;
        const char* name;
    } units[] = {{1.0, "m"},
                 {0.001, "mm"},
                 {0.01, "cm"},
                 {0.0254, "in"},
                 {0.3048, "ft"},
                 {1000.0, "km"},
                 {1200.0 / 3937.0, "us-ft"}};
    for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); ++i) {
        if (fabs(metres - units[i].metres) <= 1e-9 * units[i].metres) {
            return units[i].name;
        }
    }
    return NULL;
}
